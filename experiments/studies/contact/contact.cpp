// Whether contact obeys the laws it is given: heights of bounces, slopes that hold or not, stopping
// distances, rest; for the three laws of core/contact.hpp, the thesis's Algorithm 2 among them, whose misses
// are shown beside what the others reach. Runs are in contact_runs.cpp, what is drawn in contact_chart.cpp.
#include "experiments/studies/contact/contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace mss::studies::contact {

namespace {

Json configuration(const ContactConfig& c) {
  return {{"particle", "cell of 0.1 m without springs"},
          {"block", "3 x 3 x 3 cells of 0.1 m, E = 1 MPa, nu = 0.3, density 1000, damped by a ratio of 0.5"},
          {"cube", "the thesis's, 5 x 5 x 5 cells of 0.2 m, density 1, damped by a ratio of 0.4"},
          {"step", "1 ms, or half the limit of central differences if that is shorter"},
          {"integrators", c.integrators},
          {"integrators_of_bodies", c.block_integrators},
          {"restitutions", c.restitutions},
          {"frictions", c.frictions},
          {"degrees", c.degrees},
          {"slope", 0.5},
          {"slope_frictions", c.slope_frictions},
          {"rest_seconds", c.rest_seconds},
          {"threads", c.threads}};
}

constexpr const char* caption =
    "What contact makes of the coefficients it is given, for its three laws. A bounce should come back to "
    "e^2 of its height, a push v should end after v^2 / (2 mu g) whatever its direction, a slope should hold "
    "a body iff its tangent is at most mu and else let it slide 1/2 g (sin - mu cos) t^2. The thesis's law "
    "`thesis` multiplies all of a velocity by its loss factor at every touch and has friction without a "
    "direction; its misses are its own. `penalty` is smooth: it sinks a little, creeps on slopes, and what "
    "it gives back of a bounce depends on how fast and how stiff that is. Charts show one method; the table "
    "has them all. Left out: edges against each other, contact of bodies with bodies, other speeds.";

/// Of every study, body and law the largest error, and whose it is.
std::string summary(const Table& rows) {
  std::string lines;
  for (const std::string& study : rows.distinct("study"))
    for (const std::string& body : rows.distinct("body"))
      for (const std::string& law : rows.distinct("law")) {
        double worst = -1;
        std::string whose, failure;
        for (std::size_t r = 0; r < rows.size(); ++r) {
          if (rows.text(r, "study") != study || rows.text(r, "body") != body || rows.text(r, "law") != law)
            continue;
          if (rows.text(r, "status") != "ok") {
            failure = fmt::format("; {} {}", rows.text(r, "integrator"), rows.text(r, "status"));
          } else if (rows.number(r, "error") > worst) {
            worst = rows.number(r, "error");
            whose = fmt::format("{} at {:g}", rows.text(r, "integrator"), rows.number(r, "asked"));
          }
        }
        if (worst >= 0 || !failure.empty())
          lines += fmt::format("{:<7} {:<13} {:<8} off by at most {:<8} {}{}\n", study, body, law,
                               worst >= 0 ? fmt::format("{:.2g}", worst) : "-", whose, failure);
      }
  return lines;
}

ExperimentResult run_contact(const ExperimentOptions& options, Progress& progress) {
  const ContactConfig config = contact_config(options);
  ContactTables tables = measure_contact(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.charts = contact_charts(tables, config);
  result.summary = summary(tables.rows);
  result.tables = {{"contact", std::move(tables.rows)}, {"contact_rest", std::move(tables.rest)}};
  return result;
}

}  // namespace

std::string charted_integrator(const ContactConfig& config) {
  const auto& some = config.block_integrators;
  return some.empty() || std::find(some.begin(), some.end(), "verlet") != some.end() ? "verlet"
                                                                                     : some.front();
}

ContactConfig contact_config(const ExperimentOptions& options) {
  ContactConfig config;
  config.integrators = moving_integrators(options.integrators);
  config.block_integrators = options.integrators.empty()
                                 ? std::vector<std::string>{"verlet", "velocity_verlet", "rk4"}
                                 : config.integrators;
  config.restitutions = {0, 0.2, 0.4, 0.6, 0.8, 1};
  config.frictions = {0.1, 0.2, 0.4, 0.6};
  config.degrees = {0, 30, 45};
  config.slope_frictions = {0, 0.2, 0.4, 0.49, 0.51, 0.7};
  if (!options.quick) return config;
  if (options.integrators.empty()) {
    config.integrators = {"verlet", "velocity_verlet", "rk4", "backward_euler", "cvode_bdf"};
    config.block_integrators = {"verlet"};
  }
  config.restitutions = {0, 0.2, 0.6, 1};
  config.frictions = {0.2, 0.4};
  config.slope_frictions = {0.2, 0.49, 0.51};
  return config;
}

namespace {

/// Whether a row is the same on every machine. Under the thesis's law rounding decides whether what lies on a
/// plane is reflected or put down, and a particle that loses nothing returns to just its height, or just not.
bool is_steady(const Table& rows, std::size_t r) {
  return rows.text(r, "law") != "thesis" ||
         (rows.text(r, "study") == "bounce" && rows.number(r, "asked") != 1);
}

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  ContactConfig config = contact_config({.quick = options.quick});
  if (options.quick) {
    config.integrators = {"verlet", "velocity_verlet", "backward_euler"};
    config.restitutions = {0.2, 0.6};
    config.frictions = {0.4};
    config.degrees = {0, 45};
    config.slope_frictions = {0.49, 0.51};
    config.rest_seconds = 1;
  } else {
    std::erase_if(config.integrators,
                  [](const std::string& name) { return find_integrator(name).stepping != Stepping::fixed; });
  }
  config.threads = options.threads;
  const Table all = measure_contact(config, progress).rows;
  Table steady(all.columns());
  for (std::size_t r = 0; r < all.size(); ++r)
    if (is_steady(all, r)) steady.add(all.rows()[r]);
  return steady;
}

}  // namespace

ExperimentInfo experiment() {
  return {.name = "contact",
          .under = "validate",
          .summary = "bounces, slopes, pushes and rest on a plane against the laws of contact",
          .accepts = {.integrators = moving_integrators},
          .run = run_contact,
          .baseline = {
              .keys = {"study", "law", "integrator", "body", "asked", "angle"},
              .rules = {{"dt", 1e-12}, {"value", 1e-4, 1e-9}, {"expected", 1e-12}, {"error", 1e-2, 1e-6}},
              .table = baseline_table}};
}

}  // namespace mss::studies::contact
