// The loaded cube of `mss regimes`: stiff, damped and slow, so that only its way to rest is of interest. One
// second by explicit methods at their safe steps and by others at a step a frame, against Young's modulus.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "core/measures/measures.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/studies/regimes/regimes.hpp"

namespace mss::studies::regimes {

namespace {

constexpr const char* compared_with = "velocity_verlet";

/// A method with its linear solver, and what was measured of it.
struct LoadedRun {
  std::string name;
  const IntegratorInfo* info;
  IntegratorOptions options;
  long steps = 1;  ///< a frame
  std::vector<double> seconds = {};
  MeasuredMotion first = {};
  Measures end = {};
};

std::vector<LoadedRun> loaded_runs(const HeldCube& cube) {
  std::vector<LoadedRun> all;
  const auto add_explicit = [&](const ExplicitSteps& choice) {
    for (const LoadedRun& run : all)
      if (run.info == choice.info) return;
    all.push_back({choice.info->name, choice.info, {.dt = choice.dt}, choice.steps});
  };
  add_explicit(explicit_steps(find_integrator(compared_with), cube.system.spectral_bound(), frame));
  for (const ExplicitSteps& choice : cheapest_explicit_steps(cube.system, cube.start, frame))
    add_explicit(choice);
  for (const char* solver : {"matrix_free", "automatic"}) {
    IntegratorOptions options{.dt = frame};
    options.linear_solver = solver;
    all.push_back({std::string("backward_euler_linear, ") + solver, &find_integrator("backward_euler_linear"),
                   options});
  }
  for (const char* method :
       {"backward_euler/lbfgs:5", "backward_euler/lbfgs:10", "tr_bdf2/lbfgs:4", "generalized_alpha/lbfgs:5"})
    all.push_back({method, &find_integrator(method), {.dt = frame}});
  return all;
}

void take(const HeldCube& cube, const LoadedConfig& config, LoadedRun& run) {
  MeasuredMotion measured = measure_motion(cube, *run.info, run.options, config.frames);
  run.seconds.push_back(measured.seconds);
  if (run.seconds.size() > 1) return;
  if (measured.ok()) run.end = measure(cube.system, measured.end);
  run.first = std::move(measured);
}

/// Quickest at each modulus among the explicit methods, or those of one name.
std::map<double, double> quickest(const Table& loaded, const std::string& method) {
  std::map<double, double> least;
  for (std::size_t r = 0; r < loaded.size(); ++r) {
    const bool taken =
        method.empty() ? loaded.text(r, "kind") == "explicit" : loaded.text(r, "method") == method;
    if (!taken || loaded.text(r, "status") != "ok") continue;
    const auto [place, is_new] = least.emplace(loaded.number(r, "young"), loaded.number(r, "seconds"));
    if (!is_new) place->second = std::min(place->second, loaded.number(r, "seconds"));
  }
  return least;
}

}  // namespace

Json compute_loaded(double young, const RegimesConfig& config) {
  const LoadedConfig& c = config.loaded;
  const HeldCube cube({.young = young, .poisson = 0.3}, c.cells, c.damping_ratio, 1,
                      {{.box = {{1, 0, 0}, {1, 1, 1}}, .force = Vec3(0, 0, -c.force)}});
  std::vector<LoadedRun> runs = loaded_runs(cube);
  interleave(config.repetitions, runs.size(), Progress{}, [&](std::size_t i) { take(cube, c, runs[i]); });
  const LoadedRun& verlet = runs.front();
  const double displacement = squared_displacement(cube, verlet.first.motion);
  Json all = Json::array();
  for (const LoadedRun& run : runs) {
    const Quartiles time = quartiles(run.seconds);
    const bool ok = run.first.ok() && verlet.first.ok();
    all.push_back({{"method", run.name},
                   {"kind", run.info->implicit ? "implicit" : "explicit"},
                   {"steps", run.steps},
                   {"seconds", time.median},
                   {"q1", time.q1},
                   {"q3", time.q3},
                   {"kinetic", run.end.kinetic},
                   {"stored", run.end.elastic + run.end.volume_energy},
                   {"energy", ok ? std::abs(run.end.mechanical() / verlet.end.mechanical() - 1) : no_value},
                   {"motion", ok ? std::sqrt(squared_distance(cube, run.first.motion, verlet.first.motion) /
                                             displacement)
                                 : no_value},
                   {"status", !run.first.ok() ? std::string(to_string(run.first.status))
                              : ok            ? "ok"
                                              : std::string("nothing to compare with")}});
  }
  return all;
}

Table empty_loaded() {
  return Table({{"cells"},
                {"damping_ratio"},
                {"force", "N"},
                {"frames"},
                {"young", "Pa"},
                {"method"},
                {"kind"},
                {"steps_per_frame"},
                {"seconds", "s"},
                {"q1", "s"},
                {"q3", "s"},
                {"kinetic", "J"},
                {"stored", "J"},
                {"energy_difference"},
                {"motion_difference"},
                {"status"}});
}

void add_loaded(const LoadedConfig& config, double young, const Json& runs, Table& loaded) {
  for (const Json& run : runs) {
    std::vector<Cell> row{config.cells,
                          config.damping_ratio,
                          config.force,
                          config.frames,
                          young,
                          run["method"].get<std::string>(),
                          run["kind"].get<std::string>(),
                          run["steps"].get<std::int64_t>()};
    for (const char* column : {"seconds", "q1", "q3", "kinetic", "stored", "energy", "motion"})
      row.emplace_back(number(run[column]));
    row.emplace_back(run["status"].get<std::string>());
    loaded.add(std::move(row));
  }
}

Table loaded_crossings(const Table& loaded) {
  Table table({{"method"}, {"young", "Pa"}, {"largest_energy_difference"}, {"status"}});
  const std::map<double, double> least = quickest(loaded, "");
  for (const std::string& method : loaded.where("kind", "implicit").distinct("method")) {
    std::vector<double> log_moduli, log_ratios;
    for (const auto& [young, seconds] : quickest(loaded, method))
      if (const auto other = least.find(young); other != least.end()) {
        log_moduli.push_back(std::log(young));
        log_ratios.push_back(std::log(other->second / seconds));
      }
    const double young = crossing(log_moduli, log_ratios);
    double difference = no_value;
    const Table runs = loaded.where("method", method).where("status", "ok");
    for (std::size_t r = 0; r < runs.size(); ++r)
      if (runs.number(r, "young") >= young)
        difference = std::fmax(difference, runs.number(r, "energy_difference"));
    table.add({method, young, difference,
               std::string(std::isnan(young)                      ? "no run finished"
                           : std::log(young) < log_moduli.front() ? "costs less at every modulus tried"
                           : std::log(young) > log_moduli.back()  ? "costs more at every modulus tried"
                                                                  : "ok")});
  }
  return table;
}

Chart loaded_chart(const Table& loaded, const Table& crossings) {
  Chart chart{.title = "A stiff, damped cube on its way to rest: time against stiffness",
              .subtitle = fmt::format(
                  "{:g} cells an edge, one face held, {:g} N sideways on the other, damping ratio {:g}; {:g} "
                  "frames of 1/60 s",
                  loaded.number(0, "cells"), loaded.number(0, "force"), loaded.number(0, "damping_ratio"),
                  loaded.number(0, "frames")),
              .x = {.label = "Young's modulus [Pa]", .logarithmic = true},
              .y = {.label = "wall time, bars: quartiles", .logarithmic = true, .unit = "s"}};
  for (const std::string& method : loaded.distinct("method")) {
    const Table rows = loaded.where("method", method);
    const bool is_explicit = rows.text(0, "kind") == "explicit";
    ChartSeries series{.label = is_explicit ? method + ", safe step" : method};
    for (std::size_t r = 0; r < rows.size(); ++r)
      if (const std::string& status = rows.text(r, "status"); status != "ok") {
        series.label += fmt::format(" ({} at {:g} Pa)", status, rows.number(r, "young"));
        break;
      }
    for (std::size_t r = 0; r < rows.size(); ++r)
      if (rows.text(r, "status") == "ok")
        series.points.push_back(
            {rows.number(r, "young"), rows.number(r, "seconds"), rows.number(r, "q1"), rows.number(r, "q3")});
    chart.series.push_back(std::move(series));
  }
  for (std::size_t r = 0; r < crossings.size(); ++r)
    if (crossings.text(r, "method") == "backward_euler_linear, matrix_free" &&
        crossings.text(r, "status") == "ok")
      chart.lines.push_back({ReferenceLine::Direction::vertical, crossings.number(r, "young"), "crossing"});
  chart.lines.push_back({ReferenceLine::Direction::horizontal, loaded.number(0, "frames") * frame,
                         "as long as the motion itself"});
  return chart;
}

}  // namespace mss::studies::regimes
