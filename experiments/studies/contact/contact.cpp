// Whether contact obeys the laws whose coefficients it is given: heights of bounces, distances slid and
// stopped in, rest; for the three laws of core/environment/contact.hpp, one of which is the thesis's
// Algorithm 2. Runs are in runs.cpp, charts in chart.cpp.
#include "experiments/studies/contact/contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace mss::studies::contact {

namespace {

Json configuration(const FloorConfig& c) {
  Json scenes = Json::object(), steps = Json::array();
  for (const FloorScene& scene : floor_scenes())
    scenes[scene.name] = {{"degrees", scene.degrees}, {"friction", scene.friction},
                          {"burden", scene.burden},   {"height", scene.height},
                          {"seconds", scene.seconds}, {"quantity", scene.quantity}};
  for (const FloorStep& step : c.steps) steps.push_back(step.name);
  return {{"body", "cells of 0.05 m, density 1000, nu = 0.3, t = 0.5, damped by a ratio of 0.1"},
          {"scenes", scenes},
          {"shapes", c.shapes},
          {"integrators", c.integrators},
          {"young", c.youngs},
          {"steps", steps}};
}

template <class Run>
Json names_of(const std::vector<Run>& runs) {
  Json names = Json::array();
  for (const Run& run : runs) names.push_back(run.name());
  return names;
}

Json configuration(const CollisionConfig& c) {
  return {{"body", "cells of 0.05 m, E = 1 MPa, nu = 0.3, t = 0.5, density 1000, undamped"},
          {"bars", names_of(c.bars)},
          {"blocks", names_of(c.blocks)}};
}

Json configuration(const SphereConfig& c) {
  return {{"body", "radius 0.5 m, E = 1 MPa, nu = 0.3, t = 0.5, density 1000, undamped"},
          {"pressed", names_of(c.pressed)},
          {"impacts", names_of(c.impacts)}};
}

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
          {"floor", configuration(c.floor)},
          {"collision", configuration(c.collision)},
          {"sphere", configuration(c.sphere)},
          {"robustness", configuration(c.robustness)}};
}

constexpr const char* caption =
    "Planes, three laws: a bounce should return to e^2 of its height, a push at speed v should stop after "
    "v^2 / (2 mu g) in any direction, a body on a slope should stick if mu is at least the tangent and "
    "else slide 1/2 g (sin - mu cos) t^2. `thesis` multiplies the whole velocity by its loss factor at "
    "every contact, so its errors are inherent; `penalty` is smooth: bodies penetrate a little and creep "
    "on slopes. Charts show one method, the table has all. "
    "A body on the floor, law `impulse`, cells of 0.05 m, 1000 kg/m^3, nu = 0.3, damping ratio 0.1: a "
    "cube of four cells an edge, the same with cells missing, a torus given as a mesh; E = 0.1, 1 and 10 "
    "MPa; explicit Euler, PEFRL, the SRKN methods and the energy-momentum method, which takes a third of the "
    "time of all, run only if named. Methods with a stability limit take their safe steps, others two steps; "
    "bodies other than the "
    "cube 1/60 s, 0.1 and 10 MPa only. Besides the error of its scene, no particle may be more than 1e-12 m "
    "behind a "
    "plane, no energy grow by more than 5 percent, and the body must touch all its planes. Cost is "
    "processor time of a step over that without planes. "
    "Bodies that touch: of two equal bars, lateral motion held, the exact solution is that they touch for "
    "2 L / c, exchange velocities and do not vibrate; the duration is twice the mean time of the impulse. "
    "Two blocks in free space may change momentum and angular momentum by 1e-12 a step, and energy by 0.1 "
    "percent. An elastic sphere in cells is pressed by d on a plane or on another, and hits a plane; "
    "forces and durations are compared with the finite sphere's, linear elastic, which are not Hertz's; "
    "nothing is claimed where few vertices touch. From d = 0.02 R on strains are not small: springs yield "
    "2 to 5 percent more, in fine cells too. "
    "Blocks of 2 x 2 x 2 cells in a stack of three and a pile of nine settle for 5 s, of explicit methods by "
    "Verlet alone unless others are named, and may drift by "
    "1e-4 of a cell in the next 5; a block on a held block slides on slopes about mu = 0.5; a rope half "
    "around a cylinder is pulled and let back against a load of 20 N, beside exp(+-mu pi); a ring, a "
    "strip and an arch are brought to lie on themselves, and no triangles may go through each other by "
    "more than a tenth of a cell; bodies of five shapes fall into a box; random scenes of two to five "
    "bodies, explicit methods at half their safe steps, may gain no momentum and a hundredth of the "
    "energy at play. Left out: contact of edges, other speeds.";

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
  Journal journal = open_journal(options, configuration(config));
  ContactTables tables = measure_contact(config, options.processes, journal, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables.rows) + floor_summary(tables.floor) +
                   collision_summary(tables.bars, tables.balance) + robustness_summary(tables.robustness);
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
  std::vector<NamedTable> files{{"contact", std::move(tables.rows)},
                                {"contact_rest", std::move(tables.rest)},
                                {"contact_floor", std::move(tables.floor)},
                                {"contact_bars", std::move(tables.bars)},
                                {"contact_balance", std::move(tables.balance)},
                                {"contact_sphere", std::move(tables.spheres)},
                                {"contact_impact", std::move(tables.impacts)}};
  for (NamedTable& file : robustness_files(std::move(tables.robustness))) files.push_back(std::move(file));
  return files;
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
  config.floor = floor_config(options);
  if (options.integrators.empty()) {
    config.collision = collision_config(options.quick);
    config.sphere = sphere_config(options.quick);
  }
  config.robustness = robustness_config(options);
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

/// The study of a row of the baseline that is about a body on the floor.
std::string study_of(const std::string& scene) { return "floor " + scene; }

/// A body on the floor as rows of the baseline: the value is the largest energy over the initial one. Of what
/// is not as it should be only that counts, as its numbers may depend on rounding.
void add_floor(const Table& floor, Table& rows) {
  for (std::size_t r = 0; r < floor.size(); ++r) {
    const auto scene = std::find_if(floor_scenes().begin(), floor_scenes().end(), [&](const FloorScene& one) {
      return one.name == floor.text(r, "scene");
    });
    const bool ok = floor.text(r, "status") == "ok";
    rows.add({study_of(scene->name), std::string(to_string(ContactLaw::impulse)), floor.text(r, "integrator"),
              fmt::format("{}, {:g} Pa", floor.text(r, "shape"), floor.number(r, "young")), scene->friction,
              scene->degrees, floor.number(r, "dt"), ok ? floor.number(r, "energy") : no_value, 1.0,
              ok ? floor.number(r, "error") : no_value, floor.text(r, "status")});
  }
}

/// Bars as rows of the baseline: the value is the duration over the exact one.
void add_bars(const Table& bars, Table& rows) {
  for (std::size_t r = 0; r < bars.size(); ++r)
    rows.add({std::string("bars"), std::string("bodies"), std::string("velocity_verlet"),
              fmt::format("{:g} x {:g} cells", bars.number(r, "cells"), bars.number(r, "across")),
              bars.number(r, "stiffness"), bars.number(r, "speed_over_c"), bars.number(r, "dt"),
              bars.number(r, "duration_over_exact"), 1.0, std::abs(bars.number(r, "duration_over_exact") - 1),
              bars.text(r, "status")});
}

/// Pressed spheres likewise: the value is the force over Hertz's.
void add_spheres(const Table& spheres, Table& rows) {
  for (std::size_t r = 0; r < spheres.size(); ++r)
    rows.add({std::string("sphere"), std::string("bodies"), std::string("verlet"), spheres.text(r, "on"),
              spheres.number(r, "approach_over_radius"), 0.0, 0.0, spheres.number(r, "force_over_hertz"),
              spheres.number(r, "finite_over_hertz"), std::abs(spheres.number(r, "force_error")),
              spheres.text(r, "status")});
}

std::vector<ColumnRule> baseline_rules() {
  std::vector<ColumnRule> rules;
  for (const char* study : {"bars", "sphere"}) {
    rules.push_back({"value", 1e-3, 0, study});
    rules.push_back({"error", 1e-2, 1e-3, study});
  }
  for (const FloorScene& scene : floor_scenes()) {
    rules.push_back({"value", 1e-3, 0, study_of(scene.name)});
    rules.push_back({"error", 1e-2, scene.unit == "m" ? 1e-4 : 5e-4, study_of(scene.name)});
  }
  for (const ColumnRule& rule : {ColumnRule{"dt", 1e-9}, ColumnRule{"value", 1e-4, 1e-9},
                                 ColumnRule{"expected", 1e-12}, ColumnRule{"error", 1e-2, 1e-6}})
    rules.push_back(rule);
  return rules;
}

/// Methods that are far from the bounds of every scene, on either side.
FloorConfig floor_of_baseline(bool quick) {
  FloorConfig config =
      floor_config({.quick = true,
                    .integrators = {"verlet", "backward_euler", "backward_euler/lbfgs", "xpbd:1", "vbd:20"}});
  if (quick) config.youngs = {1e6};
  return config;
}

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  ContactConfig config = contact_config({.quick = options.quick});
  config.floor = floor_of_baseline(options.quick);
  config.collision = {.bars = collision_config(true).bars};
  config.sphere = {
      .pressed = {{.on = PressedOn::impulse, .cells = 10}, {.on = PressedOn::sphere, .cells = 10}}};
  config.robustness = {};
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
  Journal journal;
  const ContactTables tables = measure_contact(config, 1, journal, progress);
  const Table& all = tables.rows;
  Table reproducible(all.columns());
  for (std::size_t r = 0; r < all.size(); ++r)
    if (is_reproducible(all, r)) reproducible.add(all.rows()[r]);
  add_floor(tables.floor, reproducible);
  add_bars(tables.bars, reproducible);
  add_spheres(tables.spheres, reproducible);
  return reproducible;
}

}  // namespace

ExperimentInfo experiment() {
  return {.name = "contact",
          .under = "validate",
          .summary =
              "bounces, slopes, pushes and rest on a plane against the laws of contact; a block on a "
              "floor, by method and step; bodies that hit each other; elastic spheres",
          .accepts = {.integrators = moving_integrators, .processes = true},
          .run = run_contact,
          .draw = draw_contact,
          .baseline = {.keys = {"study", "law", "integrator", "body", "coefficient", "angle"},
                       .rules = baseline_rules(),
                       .table = baseline_table}};
}

}  // namespace mss::studies::contact
