// Blocks that lie on blocks: whether they stay, how deep they sink, and when they slide.
#include "experiments/studies/contact/pile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "core/base/error.hpp"
#include "core/scene/scene.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/contact/scene_text.hpp"
#include "experiments/studies/contact/touching_methods.hpp"
#include "integrators/integrator.hpp"
#include "reference/closed_forms.hpp"

namespace mss::studies::contact {

namespace {

constexpr double pile_cell = 0.05;                    ///< [m]
constexpr double pile_gravity = 9.81;                 ///< [m/s^2]
constexpr double most_drift = 1e-4;                   ///< cells
constexpr double most_depth = 0.01;                   ///< cells
constexpr double slide_begins = 0.5, slide_ends = 1;  ///< between which a slide is measured [s]

std::string block_text(const std::array<int, 3>& cells, const Vec3& origin) {
  return fmt::format("[[body]]\ncells = [{}, {}, {}]\ncell_size = {}\norigin = {}\n\n", cells[0], cells[1],
                     cells[2], pile_cell, scene_text(origin));
}

std::string material_text(double young) {
  return fmt::format(
      "[material]\ndensity = 1000\nyoung = {}\npoisson = 0.3\n\n[damping]\nviscosity = 1200\n\n", young);
}

/// Lower corners of the blocks, of two cells an edge.
std::vector<Vec3> corners_of(const std::string& pile) {
  const double edge = 2 * pile_cell;
  if (pile == "three")
    return {Vec3(0, 0, 0), Vec3(0.3 * pile_cell, 0, edge), Vec3(0, 0.3 * pile_cell, 2 * edge)};
  if (pile != "nine") throw std::logic_error("no pile " + pile);
  std::vector<Vec3> corners;
  constexpr double gap = 0.2 * pile_cell;
  for (int row = 0; row < 3; ++row)
    for (int i = 0; i < 4 - row; ++i) corners.emplace_back((i + 0.5 * row) * (edge + gap), 0, row * edge);
  return corners;
}

}  // namespace

const std::vector<std::string>& pile_names() {
  static const std::vector<std::string> all{"three", "nine"};
  return all;
}

std::string PileRun::name() const {
  return fmt::format("pile {}, {}, {:g} Pa, stiffness {:g}", pile, integrator, young, stiffness);
}

std::string InclineRun::name() const { return fmt::format("incline {:g}, {}", tangent, integrator); }

std::string pile_scene(const PileRun& run) {
  std::string said;
  for (const Vec3& corner : corners_of(run.pile)) said += block_text({2, 2, 2}, corner);
  said += material_text(run.young);
  said += fmt::format("[contact]\nbodies = true\nfriction = 0.5\nstiffness = {}\n\n", run.stiffness);
  said += fmt::format("[environment]\ngravity = [0, 0, -{}]\n\n", pile_gravity);
  said += "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nfriction = 0.5\nrestitution = 0\n\n";
  return said + solve_text(run.integrator, run.seconds, 0.05);
}

/// Blocks of 1 MPa, their particles not above each other; the lower one is held, and gravity is tilted.
std::string incline_scene(const InclineRun& run) {
  const double angle = std::atan(run.tangent);
  const double cell = pile_cell;
  std::string said =
      block_text({30, 4, 1}, Vec3(0, 0, -cell)) + block_text({2, 2, 2}, Vec3(1.3 * cell, 0.8 * cell, 0));
  said += material_text(1e6);
  said += fmt::format("[contact]\nbodies = true\nfriction = {}\n\n", incline_friction);
  said += fmt::format("[environment]\ngravity = {}\n\n",
                      scene_text(pile_gravity * Vec3(std::sin(angle), 0, -std::cos(angle))));
  said += fmt::format("[[hold]]\nbox = [[-1, -1, {}], [2, 1, {}]]\n\n", -2 * cell, -cell / 2);
  return said + solve_text(run.integrator, slide_ends, slide_begins / 30);
}

/// Explicit methods take long: of them Verlet alone puts up piles, others where they are named. Of implicit
/// ones backward Euler alone puts up the larger pile in every material.
PileConfig pile_config(const ExperimentOptions& options) {
  PileConfig config;
  const std::vector<std::string> methods = options.quick && options.integrators.empty()
                                               ? std::vector<std::string>{"backward_euler"}
                                               : touching_methods(options.integrators);
  constexpr double usual = 1e6;
  for (const std::string& pile : pile_names())
    for (const std::string& method : methods)
      for (const double young : {1e5, usual, 1e7})
        for (const double stiffness : {1.0, 10.0}) {
          const bool is_usual = young == usual && stiffness == 1, takes_long = find_integrator(method).limit;
          if (!is_usual && (options.quick || (takes_long && young > usual))) continue;
          if (takes_long && options.integrators.empty() && method != "verlet") continue;
          if (takes_long && pile != "three" && !is_usual) continue;
          if (pile != "three" && !is_usual && method != "backward_euler") continue;
          config.piles.push_back({pile, method, young, stiffness});
        }
  const std::vector<double> tangents =
      options.quick ? std::vector{0.45, 0.55} : std::vector{0.3, 0.45, 0.49, 0.51, 0.55, 0.8};
  for (const double tangent : tangents)
    for (const std::string& method : methods) config.inclines.push_back({method, tangent});
  return config;
}

namespace {

/// The row at, or first after, a time.
const SeriesRow& row_at(const SimulationResult& result, double t) {
  for (const SeriesRow& row : result.series)
    if (row.t >= t - 1e-9) return row;
  return result.series.back();
}

struct Slide {
  double slid = no_value, expected = no_value;  ///< [m]
};

/// By Coulomb's law, with the speed at the beginning: bounces of a block that was put there suddenly start
/// it.
Slide slide_of(double angle, double mass, const SimulationResult& result) {
  const SeriesRow &from = row_at(result, slide_begins), &end = result.series.back();
  const double time = end.t - from.t, speed = std::max(0.0, from.momentum[0] / mass);
  const double a = pile_gravity * (std::sin(angle) - incline_friction * std::cos(angle));
  const double moving = speed == 0 && a < 0 ? 0 : a < 0 ? std::min(time, -speed / a) : time;
  return {end.bodies.bodies[1].centre[0] - from.bodies.bodies[1].centre[0],
          speed * moving + a / 2 * moving * moving};
}

struct PileNumbers {
  double dt = no_value, drift = no_value, depth = no_value, deepest = no_value, cost = no_value;
};

/// Of any block's centre, in the second half of the time, over a cell.
double drift_of(const PileRun& run, const SimulationResult& result) {
  const std::vector<BodyMeasures>& from = row_at(result, run.seconds / 2).bodies.bodies;
  double most = 0;
  for (const SeriesRow& row : result.series)
    for (std::size_t b = 0; b < from.size() && row.t >= run.seconds / 2; ++b)
      most = std::max(most, (row.bodies.bodies[b].centre - from[b].centre).norm() / pile_cell);
  return most;
}

std::string judge_pile(const PileNumbers& n) {
  if (!(n.drift <= most_drift)) return "drifts";
  return n.depth <= most_depth ? "ok" : "sinks";
}

}  // namespace

Table empty_pile() {
  return Table({{"pile"},
                {"integrator"},
                {"young", "Pa"},
                {"stiffness"},
                {"dt", "s"},
                {"drift"},
                {"depth"},
                {"deepest"},
                {"cost"},
                {"status"},
                {"reason"}});
}

void add_pile_run(const PileRun& run, Table& rows) {
  PileNumbers n;
  const auto add = [&](const std::string& status, const std::string& reason) {
    rows.add({run.pile, run.integrator, run.young, run.stiffness, n.dt, n.drift, n.depth, n.deepest, n.cost,
              status, reason});
  };
  try {
    const Scene scene = parse_scene(pile_scene(run));
    check_solve(scene);
    Progress silent;
    const SimulationResult result = simulate(scene, silent);
    n.dt = result.dt;
    n.cost = result.wall_seconds / result.simulated_seconds;
    if (result.status != Status::ok) return add(std::string(to_string(result.status)), "");
    n.drift = drift_of(run, result);
    n.depth = result.contact->depth / pile_cell;
    n.deepest = result.contact->depth_so_far;
    add(judge_pile(n), "");
  } catch (const InputError& error) {
    add("refused", error.what());
  }
}

Table empty_incline() {
  return Table({{"integrator"},
                {"tangent"},
                {"dt", "s"},
                {"slid", "m"},
                {"expected", "m"},
                {"error"},
                {"status"},
                {"reason"}});
}

void add_incline_run(const InclineRun& run, Table& rows) {
  constexpr double allowed = 0.01;
  const double angle = std::atan(run.tangent);
  const double frictionless = reference::slope_distance(pile_gravity, angle, 0, slide_ends - slide_begins);
  const auto add = [&](double dt, const Slide& slide, const std::string& status, const std::string& reason) {
    rows.add({run.integrator, run.tangent, dt, slide.slid, slide.expected,
              std::abs(slide.slid - slide.expected) / frictionless, status, reason});
  };
  try {
    const Scene scene = parse_scene(incline_scene(run));
    check_solve(scene);
    Progress silent;
    const SimulationResult result = simulate(scene, silent);
    if (result.status != Status::ok) return add(result.dt, {}, std::string(to_string(result.status)), "");
    const Slide slide = slide_of(angle, Body(scene.others.front().body).total_mass(), result);
    add(result.dt, slide, std::abs(slide.slid - slide.expected) <= allowed * frictionless ? "ok" : "off", "");
  } catch (const InputError& error) {
    add(no_value, {}, "refused", error.what());
  }
}

namespace {

/// A series for each value of a column of text or numbers.
ChartSeries pile_series(const std::string& label, const Table& rows, const char* x, const char* y) {
  constexpr double least = 1e-9;
  ChartSeries series{.label = label};
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (std::isfinite(rows.number(r, y)))
      series.points.push_back({rows.number(r, x), std::max(least, rows.number(r, y))});
  return series;
}

}  // namespace

/// At rest methods agree: of an explicit one and an implicit one, others if they were not run.
Chart pile_depth_chart(const Table& rows) {
  Chart chart{.title = "A stack of three: how deep blocks press into each other",
              .subtitle = "three blocks of 2 x 2 x 2 cells of 5 cm, 1000 kg/m^3, viscosity 1200 Pa s",
              .x = {.label = "E", .logarithmic = true, .unit = "Pa"},
              .y = {.label = "depth / cell", .logarithmic = true},
              .lines = {{ReferenceLine::Direction::horizontal, most_depth, "a hundredth"}}};
  const Table stack = rows.where("pile", "three");
  std::vector<std::string> methods = stack.distinct("integrator");
  const auto is_shown = [](const std::string& name) { return name == "verlet" || name == "backward_euler"; };
  if (std::any_of(methods.begin(), methods.end(), is_shown)) std::erase_if(methods, std::not_fn(is_shown));
  for (const double stiffness : stack.distinct_numbers("stiffness"))
    for (const std::string& method : methods) {
      ChartSeries series =
          pile_series(fmt::format("{}, contact.stiffness {:g}", method, stiffness),
                      stack.where("stiffness", stiffness).where("integrator", method), "young", "depth");
      if (series.points.size() > 1) chart.series.push_back(std::move(series));
    }
  return chart;
}

}  // namespace mss::studies::contact
