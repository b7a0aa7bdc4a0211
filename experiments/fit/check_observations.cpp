// Whether what was measured can be of a scene.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "core/body/body.hpp"
#include "core/measures/measures.hpp"
#include "experiments/fit/observations.hpp"
#include "experiments/fit/observed_run.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/scene_check.hpp"

namespace mss::fit {

namespace {

/// The columns that series.csv of the scene has.
std::vector<std::string> columns_of(const Scene& scene) {
  std::vector<std::string> names;
  for (const MeasureColumn& column : measure_columns) names.emplace_back(column.name);
  const auto add = [&](const char* what, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      for (const char axis : {'x', 'y', 'z'}) names.push_back(fmt::format("{}_{}_{}", what, i, axis));
  };
  add("hold", scene.environment.holds.size());
  add("plane", scene.environment.planes.size());
  for (std::size_t i = 0; i < scene.environment.obstacles.size(); ++i)
    for (const char* what : {"", "_torque"})
      for (const char axis : {'x', 'y', 'z'}) names.push_back(fmt::format("obstacle_{}{}_{}", i, what, axis));
  return names;
}

void check_column(Observation& o, const Scene& scene) {
  static const std::vector<std::string> axes{"x", "y", "z"};
  for (const auto& [before, now] : renamed_columns)
    if (o.column == before) o.column = now;
  const std::vector<std::string> known = o.point ? axes : columns_of(scene);
  if (std::find(known.begin(), known.end(), o.column) != known.end()) return;
  const bool is_axis = std::find(axes.begin(), axes.end(), o.column) != axes.end();
  throw InputError(
      fmt::format("{}: column '{}' is unknown; {}{}", o.place, o.column, question(o.column, known),
                  o.point   ? "of a point give x, y or z"
                  : is_axis ? "a displacement needs point = [x, y, z]"
                            : fmt::format("series.csv of {} has {}", scene.name, fmt::join(known, ", "))));
}

/// Displacements in other units than metres are larger than a body that is held.
void check_point(Observation& o, const Scene& scene) {
  const Body body(scene.body);
  Eigen::AlignedBox3d extent;
  for (const std::ptrdiff_t site : body.sites()) extent.extend(body.rest_position(site));
  const double size = extent.sizes().maxCoeff();
  o.apart = (nearest_point(scene, *o.point) - *o.point).norm();
  if (o.apart > std::max(0.1 * size, scene.body.cell_size))
    throw InputError(
        fmt::format("{}: point [{:g}] is {:.3g} m from the nearest point of {}, which is {:.3g} m long; give "
                    "a point of the body at rest, in metres",
                    o.place, fmt::join(*o.point, ", "), o.apart, scene.name, size));
  if (scene.environment.holds.empty()) return;
  const auto largest = std::max_element(o.measured.begin(), o.measured.end(),
                                        [](double a, double b) { return std::abs(a) < std::abs(b); });
  const bool is_displacement = o.kind == Kind::at_end || o.kind == Kind::series;
  if (is_displacement && std::abs(*largest) > size)
    throw InputError(
        fmt::format("{}: a displacement {} = {:g} m is impossible for {}, which is held and "
                    "{:.3g} m long; give metres",
                    o.place, o.column, *largest, scene.name, size));
}

void check_times(const Observation& o, const RunSpec& run, const Scene& scene) {
  const bool in_time = o.kind != Kind::at_end;
  if (in_time && run.at_rest)
    throw InputError(
        fmt::format("{}: {} needs a motion, and {} is at rest (solve.integrator = \"{}\"); "
                    "give another method, or mode = 1 of a frequency",
                    o.place, to_string(o.kind), scene.name, scene.solve.integrator));
  if (o.kind != Kind::series) return;
  const double duration = scene.solve.duration;
  if (o.times.front() < 0)
    throw InputError(fmt::format("{}: time = {:g} s is before the scene begins, at 0; shift the times",
                                 o.place, o.times.front()));
  if (o.times.back() > duration * (1 + 1e-9))
    throw InputError(
        fmt::format("{}: time = {:g} s is after the end of {}, solve.duration = {:g} s; give "
                    "seconds, a longer duration, or fewer rows",
                    o.place, o.times.back(), scene.name, duration));
}

double least_spacing(const std::vector<double>& times) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < times.size(); ++i) least = std::min(least, times[i] - times[i - 1]);
  return least;
}

}  // namespace

void check_observations(Observations& data, const std::vector<std::string>& starts) {
  for (std::size_t r = 0; r < data.runs.size(); ++r) {
    RunSpec& run = data.runs[r];
    const Scene scene = run.load(starts);
    run.name = scene.name;
    check_one_body(scene, "mss fit");
    if (run.modes) {
      check_model(scene);
      continue;
    }
    check_solve(scene);
    run.at_rest = is_static(scene);
    for (Observation& o : data.observations) {
      if (o.run != r) continue;
      check_column(o, scene);
      if (o.point) check_point(o, scene);
      check_times(o, run, scene);
      if (o.kind == Kind::series) run.every = std::min(run.every, least_spacing(o.times));
    }
  }
}

}  // namespace mss::fit
