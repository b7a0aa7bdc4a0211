#include "experiments/fit/observed_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "core/base/error.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "experiments/harness/ring_down.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/reduced_model.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_run.hpp"
#include "experiments/simulation/simulation.hpp"
#include "integrators/analysis/modes.hpp"

namespace mss::fit {

namespace {

/// A quantity at the rows of a run.
struct Sampled {
  std::vector<double> t, value, slope;

  /// Cubic between rows, by values and slopes at both.
  double at(double time) const {
    if (t.size() < 2) return value.front();
    const auto after = std::clamp(std::size_t(std::upper_bound(t.begin(), t.end(), time) - t.begin()),
                                  std::size_t(1), t.size() - 1);
    const std::size_t before = after - 1;
    const double h = t[after] - t[before], s = std::clamp((time - t[before]) / h, 0.0, 1.0), r = 1 - s;
    return r * r * (1 + 2 * s) * value[before] + s * s * (1 + 2 * r) * value[after] +
           h * s * r * (r * slope[before] - s * slope[after]);
  }
};

/// Whether an equilibrium depends on the time at which it is sought.
bool changes_in_time(const Environment& environment) {
  return std::any_of(environment.holds.begin(), environment.holds.end(),
                     [](const Hold& hold) { return hold.moves(); }) ||
         std::any_of(environment.loads.begin(), environment.loads.end(),
                     [](const Load& load) { return load.history.changes(0); });
}

/// Slopes of parabolas through three rows, at the ends of straight lines.
void add_slopes(Sampled& quantity) {
  const auto& t = quantity.t;
  const auto& y = quantity.value;
  const auto secant = [&](std::size_t i) { return (y[i + 1] - y[i]) / (t[i + 1] - t[i]); };
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (i == 0 || i + 1 == t.size()) {
      quantity.slope.push_back(t.size() < 2 ? 0 : secant(i == 0 ? 0 : i - 1));
      continue;
    }
    const double before = t[i] - t[i - 1], after = t[i + 1] - t[i];
    quantity.slope.push_back((after * secant(i - 1) + before * secant(i)) / (before + after));
  }
}

/// One point, in its cell or the nearest one.
EmbeddedSurface embedded(const BodyConfig& body, const Vec3& point) {
  TriangleMesh mesh;
  mesh.vertices.push_back(point);
  return {mesh, body.voxels, body.cell_size, body.origin};
}

/// The place in the cells that is nearest.
Vec3 nearest_in_cells(const BodyConfig& config, const Vec3& place) {
  const Vec3 corner = Body(config).rest_position(embedded(config, place).site(0));
  return place.cwiseMax(corner).cwiseMin((corner.array() + config.cell_size).matrix());
}

/// The nearest particle, by where particles are at rest.
template <class Rest>
std::ptrdiff_t nearest_site(const std::vector<std::ptrdiff_t>& sites, const Vec3& place, const Rest& rest) {
  return *std::min_element(sites.begin(), sites.end(), [&](std::ptrdiff_t a, std::ptrdiff_t b) {
    return (rest(a) - place).squaredNorm() < (rest(b) - place).squaredNorm();
  });
}

/// A point that is followed: carried by its cell, or a particle where cells have several sizes.
class FollowedPoint {
 public:
  template <class Real>
  FollowedPoint(const Scene& scene, const SolidSystem<Real>& system, const Vec3& place) {
    if (is_refined(scene)) {
      const auto rest = [&](std::ptrdiff_t site) { return system.rest_position(site); };
      site_ = nearest_site(system.particles(), place, rest);
      rest_ = rest(site_);
    } else {
      rest_ = nearest_in_cells(scene.body, place);
      cell_ = embedded(scene.body, rest_);
    }
  }
  template <class Real>
  Vec3 displacement(const Field<Real>& x) const {
    return at(x) - rest_;
  }
  template <class Real>
  Vec3 velocity(const Field<Real>& v) const {
    return at(v);
  }

 private:
  template <class Real>
  Vec3 at(const Field<Real>& field) const {
    return cell_ ? cell_->at(0, field) : Vec3(field.at(site_));
  }

  std::optional<EmbeddedSurface> cell_;
  std::ptrdiff_t site_ = -1;
  Vec3 rest_ = Vec3::Zero();
};

/// A run of a scene, row by row, of which only what is observed is kept.
template <class Real>
class Recorder {
 public:
  Recorder(const Scene& scene, const Body& body, const std::vector<const Observation*>& observations)
      : scene_(scene), run_(scene, body), observations_(observations), found_(observations.size()) {
    for (const Observation* o : observations) {
      std::optional<FollowedPoint>& point = points_.emplace_back();
      if (o->point) point.emplace(scene, run_.system(), *o->point);
    }
  }

  /// The status at its end; its time is time().
  Status record(double every, const std::atomic<bool>& stop) {
    if (!add_row()) return Status::non_finite;
    const double duration = scene_.solve.duration;
    const auto rows = std::max(1L, std::lround(std::ceil(duration / every - 1e-9)));
    Work work;
    for (long row = 1; row <= rows; ++row) {
      if (stop) return Status::interrupted;
      const double before = run_.state().t;
      const Status status = run_.advance(std::min(double(row) * every, duration), work);
      if (status != Status::ok) return status;
      if (run_.state().t > before && !add_row()) return Status::non_finite;
    }
    for (std::size_t k = 0; k < found_.size(); ++k)
      if (!points_[k]) add_slopes(found_[k]);
    return Status::ok;
  }
  double time() const { return run_.state().t; }
  const std::vector<Sampled>& found() const { return found_; }

 private:
  /// False where a number is not finite.
  bool add_row() {
    const std::optional<Measures> measures = run_.measure();
    if (!measures) return false;
    const SeriesRow row{*measures, run_.reactions(run_.driven()), {}};
    if (!row.reactions.is_finite()) return false;
    run_.begin_means();
    for (std::size_t k = 0; k < found_.size(); ++k) {
      Sampled& quantity = found_[k];
      quantity.t.push_back(run_.state().t);
      if (!points_[k]) {
        quantity.value.push_back(column_of(row, observations_[k]->column));
        continue;
      }
      const Eigen::Index axis = observations_[k]->column[0] - 'x';
      quantity.value.push_back(points_[k]->displacement(run_.state().x)[axis]);
      quantity.slope.push_back(points_[k]->velocity(run_.state().v)[axis]);
    }
    return true;
  }
  static double column_of(const SeriesRow& row, const std::string& name) {
    for (const MeasureColumn& column : measure_columns)
      if (column.name == name) return column.value(row);
    double found = 0;
    for_each_component(row.reactions, [&](const std::string& component, double force) {
      if (component == name) found = force;
    });
    return found;
  }

  const Scene& scene_;
  SceneRun<Real> run_;
  const std::vector<const Observation*>& observations_;
  std::vector<std::optional<FollowedPoint>> points_;  ///< none of a column of series.csv
  std::vector<Sampled> found_;
};

/// Of the computed ring-down.
RingDown ring_down_in(const Sampled& quantity, const Observation& o) {
  std::vector<double> t, value;
  for (std::size_t i = 0; i < quantity.t.size(); ++i)
    if (quantity.t[i] >= o.from && quantity.t[i] <= o.until) {
      t.push_back(quantity.t[i]);
      value.push_back(quantity.value[i]);
    }
  return ring_down(t, value);
}

/// Adds an observation's values, or says why it has none.
void add_values(const Observation& o, const Sampled& quantity, ObservedValues& found) {
  std::vector<double>& values = found.values.emplace_back();
  if (o.kind == Kind::at_end) {
    values = {quantity.value.back()};
  } else if (o.kind == Kind::series) {
    for (const double time : o.times) values.push_back(quantity.at(time));
  } else {
    constexpr double least_rows = 4;  // from one extremum to the next
    const RingDown ring = ring_down_in(quantity, o);
    const double row = (quantity.t.back() - quantity.t.front()) / double(quantity.t.size() - 1);
    if (ring.status != "ok")
      found.problem = fmt::format("{} does not ring: {}", o.name, ring.status);
    else if (1 / (2 * ring.frequency) < least_rows * row)
      found.problem =
          fmt::format("{} rings at {:.3g} Hz, and rows are {:.3g} s apart: give a shorter solve.every",
                      o.name, ring.frequency, row);
    else
      values = {o.kind == Kind::frequency ? ring.frequency : ring.swing_damping_ratio};
  }
}

template <class Real>
ObservedValues observe_in(const Scene& scene, double every,
                          const std::vector<const Observation*>& observations,
                          const std::atomic<bool>& stop) {
  const Body body(scene.body);
  Recorder<Real> recorder(scene, body, observations);
  const Status status = recorder.record(every, stop);
  ObservedValues found;
  if (status != Status::ok) {
    found.problem = fmt::format("{} at t = {:.4g} s", to_string(status), recorder.time());
    return found;
  }
  for (std::size_t k = 0; k < observations.size() && found.problem.empty(); ++k)
    add_values(*observations[k], recorder.found()[k], found);
  return found;
}

ObservedValues modes_of(const Scene& scene, const std::vector<const Observation*>& observations) {
  const Body body(scene.body);
  const std::unique_ptr<const RefinedBody> refined = refined_body_of(scene);
  const auto system = make_solid<double>(unreduced(scene), body, refined.get(), {});
  int count = 0;
  for (const Observation* o : observations) count = std::max(count, o->mode);
  Work work;
  const Modes modes = slowest_modes(*system, system->undeformed_state(), count, work);
  ObservedValues found;
  if (modes.status != Status::ok) found.problem = to_string(modes.status);
  if (found.problem.empty() && int(modes.modes.size()) < count)
    found.problem = fmt::format("there are {} modes", modes.modes.size());
  for (const Observation* o : observations)
    if (found.problem.empty())
      found.values.push_back({modes.modes[std::size_t(o->mode - 1)].omega / (2 * std::numbers::pi)});
  return found;
}

}  // namespace

ObservedValues observe(const Scene& scene, const RunSpec& run,
                       const std::vector<const Observation*>& observations, const std::atomic<bool>& stop) {
  if (run.modes) return modes_of(scene, observations);
  check_solve(scene);
  const bool one_row = run.at_rest && !changes_in_time(scene.environment);
  const double every =
      one_row ? std::max(scene.solve.every, scene.solve.duration) : std::min(scene.solve.every, run.every);
  return scene.solve.precision == Precision::single ? observe_in<float>(scene, every, observations, stop)
                                                    : observe_in<double>(scene, every, observations, stop);
}

Vec3 nearest_point(const Scene& scene, const Vec3& place) {
  if (!is_refined(scene)) return nearest_in_cells(scene.body, place);
  const Body body(scene.body);
  const auto rest = [&](std::ptrdiff_t site) { return body.rest_position(site); };
  return rest(nearest_site(body.sites(), place, rest));
}

}  // namespace mss::fit
