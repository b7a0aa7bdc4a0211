#include "experiments/advise/trajectory.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "core/measures/distortion.hpp"
#include "core/measures/measures.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/processor_time.hpp"
#include "experiments/harness/statistics.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss::advise {

namespace {

/// Points of a body at rest as weighted means of particles, trilinear in their cells.
class Interpolator {
 public:
  Interpolator(const Body& body, const std::vector<Vec3>& points) : body_(body) {
    for (const Vec3& point : points) places_.push_back(place(point));
  }

  template <class Real>
  std::vector<Vec3> displacements(const Field<Real>& x) const {
    std::vector<Vec3> all;
    all.reserve(places_.size());
    for (const Place& place : places_) {
      Vec3 sum = Vec3::Zero();
      for (std::size_t c = 0; c < 8; ++c)
        if (place.weight[c] != 0)
          sum += place.weight[c] * (x.at(place.site[c]) - body_.rest_position(place.site[c]));
      all.push_back(sum);
    }
    return all;
  }

 private:
  struct Place {
    std::array<std::ptrdiff_t, 8> site{};
    std::array<double, 8> weight{};
  };

  /// Points between cells belong to any of these that exists. Cells of other sizes fill a mesh to other
  /// places: a point outside of all is extrapolated from the nearest.
  Place place(const Vec3& point) const {
    constexpr double beside = 1e-6;
    const BodyConfig& config = body_.config();
    const Vec3 at = (point - config.origin) / config.cell_size;
    for (int side = 0; side < 8; ++side) {
      std::array<int, 3> cell{};
      for (int a = 0; a < 3; ++a)
        cell[std::size_t(a)] = int(std::floor(at[a] + (corner_bit(side, a) != 0 ? -beside : beside)));
      if (config.voxels.at(cell[0], cell[1], cell[2])) return in_cell(cell, at);
    }
    return in_cell(nearest_cell(at), at);
  }

  std::array<int, 3> nearest_cell(const Vec3& at) const {
    const VoxelGrid& voxels = body_.config().voxels;
    std::array<int, 3> nearest{};
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < voxels.nz(); ++k)
      for (int j = 0; j < voxels.ny(); ++j)
        for (int i = 0; i < voxels.nx(); ++i) {
          const double distance = (at - Vec3(i + 0.5, j + 0.5, k + 0.5)).squaredNorm();
          if (!voxels.at(i, j, k) || distance >= least) continue;
          least = distance;
          nearest = {i, j, k};
        }
    return nearest;
  }
  Place in_cell(const std::array<int, 3>& cell, const Vec3& at) const {
    Place place;
    for (int c = 0; c < 8; ++c) {
      double weight = 1;
      for (int a = 0; a < 3; ++a) {
        const double share = at[a] - cell[std::size_t(a)];
        weight *= corner_bit(c, a) != 0 ? share : 1 - share;
      }
      place.site[std::size_t(c)] =
          body_.lattice().site(cell[0], cell[1], cell[2]) + body_.lattice().corner(c);
      place.weight[std::size_t(c)] = weight;
    }
    return place;
  }

  const Body& body_;
  std::vector<Place> places_;
};

double squared_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return sum / double(a.size());
}

/// Mean displacement over the samples there are.
std::vector<Vec3> mean_of(const Trajectory& trajectory) {
  std::vector<Vec3> mean;
  int seen = 0;
  for (const Trajectory::Sample& sample : trajectory.samples) {
    if (sample.displacement.empty()) continue;
    mean.resize(sample.displacement.size(), Vec3::Zero());
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += sample.displacement[i];
    ++seen;
  }
  for (Vec3& m : mean) m /= seen;
  return mean;
}

/// The direction, over all points, in which a trajectory deviates most from its mean: its first principal
/// component, from the inner products of its samples.
std::vector<Vec3> largest_motion(const Trajectory& trajectory) {
  const std::vector<Vec3> mean = mean_of(trajectory);
  const auto samples = Eigen::Index(trajectory.samples.size()), numbers = Eigen::Index(3 * mean.size());
  Eigen::MatrixXd rows(samples, numbers);
  for (Eigen::Index l = 0; l < samples; ++l)
    for (std::size_t i = 0; i < mean.size(); ++i)
      rows.row(l).segment<3>(Eigen::Index(3 * i)) =
          (trajectory.samples[std::size_t(l)].displacement[i] - mean[i]).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> common(rows * rows.transpose());
  const Eigen::VectorXd shape = rows.transpose() * common.eigenvectors().col(samples - 1);
  std::vector<Vec3> out(mean.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = shape.segment<3>(Eigen::Index(3 * i));
  return out;
}

}  // namespace

const std::vector<std::string>& error_names() {
  static const std::vector<std::string> names{"displacement", "deformation", "volume", "frequency", "energy"};
  return names;
}

std::vector<Vec3> deformation(const std::vector<Vec3>& rest, const std::vector<Vec3>& displacement) {
  Eigen::Matrix3Xd from(3, Eigen::Index(rest.size())), to = from;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    from.col(Eigen::Index(i)) = rest[i];
    to.col(Eigen::Index(i)) = rest[i] + displacement[i];
  }
  const Eigen::Matrix4d motion = Eigen::umeyama(from, to, false);
  const Eigen::Matrix3d back = motion.topLeftCorner<3, 3>().transpose();
  const Eigen::Matrix3Xd left = back * (to.colwise() - Vec3(motion.topRightCorner<3, 1>())) - from;
  std::vector<Vec3> all;
  all.reserve(rest.size());
  for (Eigen::Index i = 0; i < left.cols(); ++i) all.emplace_back(left.col(i));
  return all;
}

ErrorEstimator::ErrorEstimator(ErrorOf of, Trajectory reference) : of_(of), reference_(std::move(reference)) {
  double displaced = 0, held = 0;
  for (const Trajectory::Sample& sample : reference_.samples) {
    double squared = 0;
    for (const Vec3& u : sample.displacement) squared += u.squaredNorm();
    displaced = std::max(displaced, std::sqrt(squared / double(sample.displacement.size())));
    held = std::max(held, sample.exchanged);
  }
  if (of_ == ErrorOf::displacement || of_ == ErrorOf::deformation) scale_ = displaced;
  if (of_ == ErrorOf::energy) scale_ = held;
  if (of_ == ErrorOf::frequency) {
    shape_ = largest_motion(reference_);
    scale_ = frequency(reference_);
  }
}

double ErrorEstimator::error_at(const Trajectory& trajectory, std::size_t sample) const {
  const Trajectory::Sample &seen = trajectory.samples[sample], &truth = reference_.samples[sample];
  switch (of_) {
    case ErrorOf::displacement:
    case ErrorOf::deformation:
      return std::sqrt(squared_distance(seen.displacement, truth.displacement)) / scale_;
    case ErrorOf::volume:
      return std::abs(seen.volume_ratio - truth.volume_ratio);
    case ErrorOf::energy:
      return std::abs(seen.energy - truth.energy) / scale_;
    case ErrorOf::frequency:
      break;
  }
  return 0;
}

double ErrorEstimator::error_of(const Trajectory& trajectory) const {
  if (of_ == ErrorOf::frequency) return std::abs(frequency(trajectory) / scale_ - 1);
  double largest = 0;
  for (std::size_t sample = 0; sample < trajectory.samples.size(); ++sample)
    if (!trajectory.samples[sample].displacement.empty())
      largest = std::max(largest, error_at(trajectory, sample));
  return largest;
}

/// Half the number of times that the motion along the largest principal component crosses its mean, over the
/// time from the first crossing to the last, in sampling intervals.
double ErrorEstimator::frequency(const Trajectory& trajectory) const {
  constexpr int least = 3;
  const std::vector<Vec3> mean = mean_of(trajectory);
  double before = 0, before_at = 0, first = no_value, last = no_value;
  int crossings = 0;
  for (std::size_t sample = 0; sample < trajectory.samples.size(); ++sample) {
    const std::vector<Vec3>& u = trajectory.samples[sample].displacement;
    if (u.empty()) continue;
    double along = 0;
    for (std::size_t i = 0; i < u.size(); ++i) along += shape_[i].dot(u[i] - mean[i]);
    if (before * along < 0) {
      last = before_at + (double(sample) - before_at) * before / (before - along);
      if (crossings++ == 0) first = last;
    }
    if (along != 0) {
      before = along;
      before_at = double(sample);
    }
  }
  return crossings < least ? no_value : (crossings - 1) / (2 * (last - first));
}

Trajectory extrapolate(const Trajectory& coarse, const Trajectory& fine, double factor) {
  const double share = 1 / (factor * factor - 1);
  Trajectory limit = fine;
  for (std::size_t l = 0; l < fine.samples.size(); ++l) {
    Trajectory::Sample& sample = limit.samples[l];
    const Trajectory::Sample& before = coarse.samples[l];
    for (std::size_t i = 0; i < sample.displacement.size(); ++i)
      sample.displacement[i] += share * (sample.displacement[i] - before.displacement[i]);
    sample.volume_ratio += share * (sample.volume_ratio - before.volume_ratio);
    sample.energy += share * (sample.energy - before.energy);
    sample.exchanged += share * (sample.exchanged - before.exchanged);
  }
  return limit;
}

namespace {

constexpr double rounding = 1e-9;

/// Samples in a frame: 1 where they are further apart.
int samples_per_frame(const Sampling& sampling) {
  return std::max(1, int(std::lround(frame / sampling.interval)));
}

}  // namespace

Sampling sampling_of(const Scene& scene, ErrorOf of) {
  constexpr std::size_t most_points = 300;
  constexpr double least_count = 128;
  const Body body(scene.body);
  const double frames = scene.solve.duration / frame;
  Sampling sampling;
  sampling.of = of;
  sampling.interval = frames < least_count ? frame / std::ceil(least_count / frames - rounding)
                                           : frame * std::floor(frames / least_count + rounding);
  sampling.count = int(std::floor(scene.solve.duration / sampling.interval + rounding * least_count));
  // At random, but always the same: even strides through a lattice stay in one of its planes.
  std::vector<std::ptrdiff_t> sites(body.sites().begin(), body.sites().end());
  std::mt19937 random(1);
  const std::size_t points = std::min(sites.size(), most_points);
  for (std::size_t i = 0; i < points; ++i) {
    std::swap(sites[i], sites[i + random() % (sites.size() - i)]);
    sampling.points.push_back(body.rest_position(sites[i]));
  }
  return sampling;
}

double by_work(const Effort& effort) {
  constexpr double second = 2e-8;             // of a force on a particle, or a vertex and planes
  constexpr double element = 12;              // force on a particle of elements over that of springs
  constexpr double solve = 10, factor = 100;  // of a linear system in forces, and the least of factors,
  constexpr double growth = 0.5;              // which takes a number of forces that grows with the body
  const Work& w = effort.work;
  const auto particles = double(effort.particles), per_force = effort.of_elements ? element : 1;
  const double forces = double(w.steps) + per_force * double(w.force_evaluations + w.products) +
                        solve * double(w.linear_solves) +
                        std::max(factor, growth * particles) * double(w.factorisations);
  return second * (particles * forces + double(effort.touched) * double(w.steps));
}

double SampledRun::total_seconds() const { return std::accumulate(seconds.begin(), seconds.end(), 0.0); }

double SampledRun::cost() const {
  constexpr double several = 3;
  if (seconds.empty()) return no_value;
  const double most = several * quantile(seconds, 0.75);
  double sum = 0;
  for (const double sample : seconds) sum += most > 0 ? std::min(sample, most) : sample;
  return sum / simulated;
}

double SampledRun::busiest() const {
  constexpr double most = 0.9;
  return seconds.empty() ? no_value : quantile(seconds, most) * double(seconds.size()) / simulated;
}

int steps_per_frame(double dt) { return int(std::lround(frame / dt)); }

double step_between_samples(double most, const Sampling& sampling) {
  const int samples = samples_per_frame(sampling);
  const double steps = std::max(1.0, std::ceil(frame / samples / most - rounding));
  return frame / (samples * steps);
}

double frame_step(double most, const Sampling& sampling) {
  constexpr int many = 16;  // steps between samples, to which one more is little
  const double steps = std::max(1.0, std::ceil(frame / most - rounding));
  if (steps >= many * samples_per_frame(sampling)) return step_between_samples(most, sampling);
  return frame / steps;
}

namespace {

/// Only what the error is of: to measure small bodies would take longer than their steps.
template <class Real>
Trajectory::Sample sample_of(const SolidSystem<Real>& system, const State<Real>& state, ErrorOf of) {
  Trajectory::Sample sample;
  if (of == ErrorOf::volume) sample.volume_ratio = volume_ratio(system.levels(), state.x);
  if (of == ErrorOf::energy) {
    const Measures m = measure(system, state);
    sample.energy = m.total();
    sample.exchanged = m.mechanical();
  }
  return sample;
}

/// How often the time that a run takes is checked per sampling interval, if that is limited.
constexpr int slices_of_an_interval = 16;
/// Adaptive methods that need more steps per sampling interval are not the cheapest.
constexpr long most_steps_between_samples = 512;

template <class Real>
SampledRun sample_in(const Scene& scene, const Sampling& sampling, const GoOn& go_on, const Charge& charge,
                     double most_seconds) {
  const Body body(scene.body);
  // Adaptive methods would have to restart at every slice; their steps are counted.
  const bool adaptive = find_integrator(scene.solve.integrator).stepping == Stepping::adaptive;
  const int slices = std::isfinite(most_seconds) && !adaptive ? slices_of_an_interval : 1;
  SceneRun<Real> scene_run(scene, body, most_steps_between_samples);
  const State<Real>& state = scene_run.state();
  const Interpolator interpolator(body, sampling.points);
  SampledRun run;
  Work work;
  const auto& surface = scene.environment.contact_surface;
  const bool is_alone = scene_run.system().threads() == 1;
  const auto effort = [&](double seconds) {
    return Effort{.seconds = seconds,
                  .work = work,
                  .particles = body.sites().size(),
                  .touched = surface ? surface->vertices.size() : 0,
                  .of_elements = !has_springs(scene.model)};
  };
  double before = 0;
  double stepped = 0;  // [s]
  double charged = 0;  // until the last sample [s]
  int seen = 0;
  for (int sample = 0; sample <= sampling.count; ++sample) {
    const double t = sample * sampling.interval;
    const Stopwatch by_clock;
    const ProcessorStopwatch of_processor;
    const auto seconds = [&] { return is_alone ? of_processor.seconds() : by_clock.seconds(); };
    const auto charged_since = [&] { return charge(effort(stepped + seconds())) - charged; };
    for (int slice = slices - 1; sample > 0 && slice >= 0 && run.status == Status::ok; --slice) {
      run.status = scene_run.advance(t - slice * sampling.interval / slices, work);
      if (slice == 0 || !(charged_since() > most_seconds * (sample - seen))) continue;
      run.ended_early = true;
      break;
    }
    const double waited = charged_since();
    stepped += seconds();
    run.work = by_work(effort(0));
    run.simulated = state.t;
    const bool over = run.ended_early || run.status != Status::ok;
    const bool passed = std::abs(state.t - t) > 1e-6 * sampling.interval;  // by a step that ends beyond it
    if (sample > 0 && (over || !passed)) {
      run.seconds.push_back(waited);
      charged += waited;
    }
    if (over) return run;
    run.trajectory.samples.emplace_back();
    if (passed) continue;
    seen = sample;
    Trajectory::Sample now = sample_of(scene_run.system(), state, sampling.of);
    if (!is_finite(state) || !std::isfinite(now.volume_ratio) || !std::isfinite(now.energy)) {
      run.status = Status::non_finite;
      return run;
    }
    if (sample == 0) before = now.energy;
    now.energy -= before;
    now.displacement = interpolator.displacements(state.x);
    if (sampling.of == ErrorOf::deformation)
      now.displacement = deformation(sampling.points, now.displacement);
    Trajectory& trajectory = run.trajectory;
    const std::vector<Level>& levels = scene_run.system().levels();
    trajectory.min_jacobian = std::min(trajectory.min_jacobian, min_jacobian(levels, state.x));
    trajectory.max_stretch = std::max(trajectory.max_stretch, max_stretch(levels, state.x));
    run.trajectory.samples.back() = std::move(now);
    if (sample > 0 && sample < sampling.count && !go_on(run)) {
      run.ended_early = true;
      return run;
    }
  }
  return run;
}

}  // namespace

SampledRun sample_scene(const Scene& scene, const Sampling& sampling, const GoOn& go_on, const Charge& charge,
                        double most_seconds) {
  const bool single = scene.solve.precision == Precision::single;
  return single ? sample_in<float>(scene, sampling, go_on, charge, most_seconds)
                : sample_in<double>(scene, sampling, go_on, charge, most_seconds);
}

}  // namespace mss::advise
