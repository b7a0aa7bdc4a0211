// Whether contact obeys the laws whose coefficients it is given: heights of bounces, distances slid and
// stopped in, rest; for the three laws of core/contact.hpp, one of which is the thesis's Algorithm 2. Runs
// are in runs.cpp, charts in chart.cpp.
#include "experiments/studies/contact/contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

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
    "Response of contact to the coefficients it is given, for its three laws. A bounce should return to "
    "e^2 of its height, a push at speed v should stop after v^2 / (2 mu g) in any direction, and a body on a "
    "slope should stick if mu is at least the tangent and else slide 1/2 g (sin - mu cos) t^2. The thesis's "
    "law `thesis` multiplies the whole velocity by its loss factor at every contact, and its friction has no "
    "direction; its errors are inherent. `penalty` is smooth: it lets bodies penetrate a little and creep on "
    "slopes, and its restitution depends on speed and stiffness. Charts show one method; the table has all. "
    "Left out: contact of edges, contact between bodies, other speeds.";

/// The largest error of every study, body and law, with the method and coefficient that have it.
std::string summary(const Table& rows) {
  std::string lines;
  for (const std::string& study : rows.distinct("study"))
    for (const std::string& body : rows.distinct("body"))
      for (const std::string& law : rows.distinct("law")) {
        double worst = -1;
        std::string where, failure;
        for (std::size_t r = 0; r < rows.size(); ++r) {
          if (rows.text(r, "study") != study || rows.text(r, "body") != body || rows.text(r, "law") != law)
            continue;
          if (rows.text(r, "status") != "ok") {
            failure = fmt::format("; {} {}", rows.text(r, "integrator"), rows.text(r, "status"));
          } else if (rows.number(r, "error") > worst) {
            worst = rows.number(r, "error");
            where = fmt::format("{} at {:g}", rows.text(r, "integrator"), rows.number(r, "coefficient"));
          }
        }
        if (worst >= 0 || !failure.empty())
          lines += fmt::format("{:<7} {:<13} {:<8} error at most {:<8} {}{}\n", study, body, law,
                               worst >= 0 ? fmt::format("{:.2g}", worst) : "-", where, failure);
      }
  return lines;
}

ExperimentResult run_contact(const ExperimentOptions& options, Progress& progress) {
  const ContactConfig config = contact_config(options);
  ContactTables tables = measure_contact(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables.rows);
  result.tables = contact_files(std::move(tables));
  return result;
}

}  // namespace

const char* to_string(Study study) {
  switch (study) {
    case Study::bounce:
      return "bounce";
    case Study::stop:
      return "stop";
    case Study::slope:
      return "slope";
    case Study::rest:
      return "rest";
    case Study::depth:
      return "depth";
    case Study::flight:
      return "flight";
  }
  return "";
}

const char* to_string(BodyKind body) {
  switch (body) {
    case BodyKind::particle:
      return "particle";
    case BodyKind::block:
      return "block";
    case BodyKind::thesis_cube:
      return "thesis's cube";
  }
  return "";
}

std::vector<NamedTable> contact_files(ContactTables tables) {
  return {{"contact", std::move(tables.rows)}, {"contact_rest", std::move(tables.rest)}};
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

/// Whether a row is the same on every machine. Under the thesis's law rounding decides whether a particle on
/// a plane is reflected or placed on it, and whether one that loses nothing returns to its height.
bool is_reproducible(const Table& rows, std::size_t r) {
  return rows.text(r, "law") != to_string(ContactLaw::thesis) ||
         (rows.text(r, "study") == to_string(Study::bounce) && rows.number(r, "coefficient") != 1);
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
  Table reproducible(all.columns());
  for (std::size_t r = 0; r < all.size(); ++r)
    if (is_reproducible(all, r)) reproducible.add(all.rows()[r]);
  return reproducible;
}

}  // namespace

ExperimentInfo experiment() {
  return {.name = "contact",
          .under = "validate",
          .summary = "bounces, slopes, pushes and rest on a plane against the laws of contact",
          .accepts = {.integrators = moving_integrators},
          .run = run_contact,
          .draw = draw_contact,
          .baseline = {
              .keys = {"study", "law", "integrator", "body", "coefficient", "angle"},
              .rules = {{"dt", 1e-12}, {"value", 1e-4, 1e-9}, {"expected", 1e-12}, {"error", 1e-2, 1e-6}},
              .table = baseline_table}};
}

}  // namespace mss::studies::contact
