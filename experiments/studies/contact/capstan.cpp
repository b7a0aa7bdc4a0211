// A rope around a cylinder: friction multiplies its tension.
#include "experiments/studies/contact/capstan.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/base/error.hpp"
#include "core/scene/scene.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/contact/touching_methods.hpp"
#include "reference/closed_forms.hpp"

namespace mss::studies::contact {

namespace {

constexpr double half_length = 1;                          ///< of the rope [m]
constexpr double cylinder_radius = 0.2;                    ///< [m]
constexpr double load = 20;                                ///< [N]
constexpr double pull = 0.2;                               ///< how far the end is pulled, then let back [m]
constexpr double wound = 0.8;                              ///< when the rope hangs down on both sides [s]
constexpr double pulling = 1.2, letting = 3.2, end = 5.2;  ///< when these begin, and the end [s]
constexpr double sliding = 0.5;   ///< share of their time after which the rope slides
constexpr double allowed = 0.05;  ///< of the ratio

/// Where the left end has moved when the rope is wound by an angle on either side of the top.
Vec3 wound_by(double angle) {
  const double free = half_length - cylinder_radius * angle;
  return {half_length - cylinder_radius * std::sin(angle) - free * std::cos(angle), 0,
          cylinder_radius * std::cos(angle) - free * std::sin(angle) - cylinder_radius};
}

std::string row_text(double t, const Vec3& x) { return fmt::format("[{}, {}, 0, {}], ", t, x[0], x[2]); }

/// Rows that wind the rope on.
std::string winding_text(double side) {
  constexpr int rows = 8;
  std::string said;
  for (int i = 0; i <= rows; ++i) {
    const Vec3 x = wound_by(double(i) / rows * std::numbers::pi / 2);
    said += row_text(double(i) / rows * wound, {side * x[0], 0, x[2]});
  }
  return said;
}

std::string pulling_text() {
  const Vec3 at = wound_by(std::numbers::pi / 2);
  return row_text(pulling, at) + row_text(letting, at - pull * Vec3::UnitZ()) + row_text(end, at);
}

}  // namespace

std::string CapstanRun::name() const {
  return fmt::format("rope {}, {}, friction {:g}", links, integrator, friction);
}

std::vector<CapstanRun> capstan_config(const ExperimentOptions& options) {
  std::vector<CapstanRun> runs;
  const std::vector<std::string> methods = options.integrators.empty()
                                               ? std::vector<std::string>{"verlet"}
                                               : touching_methods(options.integrators);
  for (const std::string& method : methods)
    for (const int links : {32, 64})
      for (const double friction : {0.1, 0.3, 0.5})
        if (!options.quick || (links == 32 && friction == 0.3)) runs.push_back({method, links, friction});
  return runs;
}

/// The right end, which is guided, is free to move up and down.
std::string capstan_scene(const CapstanRun& run) {
  const std::string left = "box = [[-1.001, -1, -1], [-0.999, 1, 1]]\n",
                    right = "box = [[0.999, -1, -1], [1.001, 1, 1]]\n";
  std::string said =
      fmt::format("[body]\ncells = [{}, 0, 0]\ncell_size = {}\nthickness = 0.02\norigin = [{}, 0, {}]\n\n",
                  run.links, 2 * half_length / run.links, -half_length, cylinder_radius);
  said += "[material]\ndensity = 1100\nyoung = 5e6\n\n[damping]\nviscosity = 5000\n\n";
  said += fmt::format(
      "[[obstacle]]\nshape = \"cylinder\"\nradius = {}\nlength = 1\ncentre = [0, 0, 0]\naxis = [0, 1, 0]\n"
      "friction = {}\nrestitution = 0\n\n",
      cylinder_radius, run.friction);
  said += "[[hold]]\n" + left + fmt::format("path = [{}{}]\n\n", winding_text(1), pulling_text());
  said += "[[hold]]\n" + right + fmt::format("axes = \"xy\"\npath = [{}]\n\n", winding_text(-1));
  said += "[[load]]\n" + right + fmt::format("force = [0, 0, -{}]\n\n", load);
  return said + solve_text(run.integrator, end, 0.01);
}

namespace {

/// Mean force that pulls the left end down, over the load, while the rope slides.
double tension_from(double from, const SimulationResult& result) {
  const double until = from + (end - letting), begins = from + sliding * (end - letting);
  double sum = 0;
  int count = 0;
  for (const SeriesRow& row : result.series)
    if (row.t > begins && row.t < until) {
      sum -= row.reactions.holds[0][2];
      ++count;
    }
  return sum / count / load;
}

}  // namespace

Table empty_capstan() {
  return Table({{"integrator"},
                {"links"},
                {"friction"},
                {"motion"},
                {"dt", "s"},
                {"ratio"},
                {"expected"},
                {"error"},
                {"status"},
                {"reason"}});
}

void add_capstan_run(const CapstanRun& run, Table& rows) {
  const auto add = [&](const char* motion, double expected, double dt, double ratio,
                       const std::string& status, const std::string& reason) {
    rows.add({run.integrator, std::int64_t(run.links), run.friction, std::string(motion), dt, ratio, expected,
              ratio / expected - 1, status, reason});
  };
  const double pulled = reference::capstan_ratio(run.friction, std::numbers::pi);
  const auto add_failed = [&](double dt, const std::string& status, const std::string& reason) {
    add("pulled", pulled, dt, no_value, status, reason);
    add("let back", 1 / pulled, dt, no_value, status, reason);
  };
  try {
    const Scene scene = parse_scene(capstan_scene(run));
    check_solve(scene);
    Progress silent;
    const SimulationResult result = simulate(scene, silent);
    if (result.status != Status::ok) return add_failed(result.dt, std::string(to_string(result.status)), "");
    const auto judged = [&](const char* motion, double from, double expected) {
      const double ratio = tension_from(from, result);
      add(motion, expected, result.dt, ratio, std::abs(ratio / expected - 1) <= allowed ? "ok" : "off", "");
    };
    judged("pulled", pulling, pulled);
    judged("let back", letting, 1 / pulled);
  } catch (const InputError& error) {
    add_failed(no_value, "refused", error.what());
  }
}

}  // namespace mss::studies::contact
