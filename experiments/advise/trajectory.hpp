#pragma once

#include <array>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/body/body.hpp"
#include "core/scene/scene.hpp"
#include "integrators/integrator.hpp"

namespace mss::advise {

/// Budgets, costs and steps are of frames.
inline constexpr double frames_per_second = 60;
inline constexpr double frame = 1 / frames_per_second;  ///< [s]
/// Milliseconds a frame, of seconds a simulated second.
inline constexpr double to_frame = 1e3 * frame;

/// What two motions of one scene are compared by.
enum class ErrorOf {
  displacement,  ///< of points, root mean square over them, over the largest of the reference
  deformation,   ///< the same of displacements in the body's own frame, see deformation()
  volume,        ///< over the volume at rest
  frequency,     ///< of the reference's largest motion, over itself
  energy         ///< gained since the start, over the largest that the reference moves and stores
};
/// As options spell them, in the enumeration's order.
const std::vector<std::string>& error_names();

/// A motion, sampled at equal intervals from its start on. Where a step is longer than the interval, samples
/// within it are empty.
struct Trajectory {
  struct Sample {
    /// Of the sampled points [m], or their deformation, if the error is of that; empty: no sample.
    std::vector<Vec3> displacement{};
    double volume_ratio = 1;
    double energy = 0;     ///< total, less that at the start [J]
    double exchanged = 0;  ///< kinetic and elastic, the scale of errors of energy [J]
  };
  std::vector<Sample> samples;
  double min_jacobian = 1;  ///< smallest of all samples: 0 or less where the body folds
  double max_stretch = 0;   ///< largest of all samples
};

/// What is left of displacements of points, given at rest, without the rigid motion that fits them best
/// (Kabsch 1976, Umeyama 1991), in the frame of the body at rest [m].
std::vector<Vec3> deformation(const std::vector<Vec3>& rest, const std::vector<Vec3>& displacement);

/// Errors of motions against a reference.
class ErrorEstimator {
 public:
  ErrorEstimator(ErrorOf of, Trajectory reference);

  const Trajectory& reference() const { return reference_; }
  /// What errors are relative to; 0 if the reference does not move at all, NaN if it has no frequency.
  double scale() const { return scale_; }

  /// Whether there is an error before the end of a motion: of the frequency there is none.
  bool known_early() const { return of_ != ErrorOf::frequency; }
  /// Error of one sample, which must not be empty.
  double error_at(const Trajectory& trajectory, std::size_t sample) const;
  /// Largest error of any sample, or that of the frequency; NaN if the trajectory has none.
  double error_of(const Trajectory& trajectory) const;

 private:
  double frequency(const Trajectory& trajectory) const;

  ErrorOf of_;
  Trajectory reference_;
  double scale_ = 1;
  std::vector<Vec3> shape_;  ///< of the largest motion
};

/// Richardson extrapolation of second order in the size of cells; those of `fine` are smaller by a factor.
Trajectory extrapolate(const Trajectory& coarse, const Trajectory& fine, double factor);

/// Where and when a run is sampled.
struct Sampling {
  std::vector<Vec3> points;  ///< at rest [m]
  double interval = 0;       ///< [s]; so many frames, or a frame over a whole number
  int count = 0;             ///< after the start
  ErrorOf of{};              ///< what to sample: volume and energy only if the error is of them

  /// Of all intervals [s]: the scene's, but for a rest that is shorter than one.
  double duration() const { return count * interval; }
};
/// At most 300 of the scene's particles, 128 to 256 times.
Sampling sampling_of(const Scene& scene, ErrorOf of);

/// The longest of the steps frame / k, k whole, up to `most` [s]; where k is large, of those that end at
/// every sample.
double frame_step(double most, const Sampling& sampling);
/// The longest step frame / k up to `most` that ends at every sample [s].
double step_between_samples(double most, const Sampling& sampling);
/// k of a step frame / k.
int steps_per_frame(double dt);

/// What a computation took.
struct Effort {
  double seconds = 0;  ///< of the processor on one thread, else by the clock
  Work work{};
  std::size_t particles = 0;
  std::size_t touched = 0;   ///< vertices of a surface that planes touch
  bool of_elements = false;  ///< that fill the cells in place of springs
};
/// What is charged for it [s]; no less for more of it.
using Charge = std::function<double(const Effort&)>;
/// What users wait for.
inline double by_the_clock(const Effort& effort) { return effort.seconds; }
/// What its work takes one core of the machine that measured results/, within a factor of two: the same on
/// every machine, however busy. A force on a particle is counted as 20 ns.
double by_work(const Effort& effort);

/// A sampled run and how it ended.
struct SampledRun {
  Status status = Status::ok;
  Trajectory trajectory;
  std::vector<double> seconds{};  ///< charged for stepping, from one sample to the next
  double work = 0;                ///< by_work(), all of it [s]
  double simulated = 0;           ///< [s]
  bool ended_early = false;

  /// Of stepping so far.
  double total_seconds() const;
  /// Seconds of stepping per simulated second. Intervals that took three times as long as the upper quartile
  /// are counted as that: the processor was busy with something else.
  double cost() const;
  /// The same of the busiest intervals: nine of ten took less.
  double busiest() const;
};
/// Whether to go on after a sample.
using GoOn = std::function<bool(const SampledRun&)>;
/// Runs a scene; after every sample it ends unless `go_on` returns true. It also ends where it is charged
/// more than `most_seconds` per interval, or an adaptive method takes more than 512 steps.
SampledRun sample_scene(const Scene& scene, const Sampling& sampling, const GoOn& go_on,
                        const Charge& charge = by_the_clock,
                        double most_seconds = std::numeric_limits<double>::infinity());

}  // namespace mss::advise
