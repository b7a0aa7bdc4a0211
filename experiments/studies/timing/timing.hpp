#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/body.hpp"
#include "core/sweep.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/measure.hpp"

namespace mss::studies::timing {

/// How long one update of a cube takes, against its cells per edge, for every method beside the others.
struct TimingConfig {
  std::vector<int> cells;  ///< per edge, ascending
  std::vector<int> algorithm1_threads{1, 2, 8};
  std::vector<int> core_threads{1};
  /// Over all sizes, up and down in turn: a machine that slows down or recovers over minutes then does so for
  /// all sizes alike, and leaves exponents alone.
  int passes = 3;
  int repetitions = 27;          ///< samples per method and size, over all passes
  double sample_seconds = 4e-3;  ///< a sample takes as many updates as last this long
  /// Large bodies get fewer repetitions to stay near this, but at least fewest_repetitions.
  double seconds_per_size = 20;
  int fewest_repetitions = 5;
  int largest_oracle = 100;  ///< cells per edge up to which Algorithm 1 is built: it needs 1.5 GB there
};

struct TimingTables {
  Table rows;  ///< one per method and size
  Table raw;   ///< one per sample, in the order they were taken
  Status status = Status::ok;
};

/// The workload: a full cube of this edge and material, whatever the number of cells.
struct TimingWorkload {
  static constexpr double edge = 1;        ///< [m]
  static constexpr double density = 1000;  ///< [kg/m^3]
  static constexpr ElasticConstants material{.young = 1e5, .poisson = 0.3};
  static constexpr double face_share = 0.5;
  static constexpr double damping_ratio = 0.05;
  static constexpr double gravity = -9.81;  ///< along z [m/s^2]
  static constexpr double stretch = 1.01;   ///< of the start along z, so that springs have something to do
  static constexpr double dt = 1e-5;        ///< [s]; a fiftieth of the stability limit at n = 100
};

/// The times a frame may take: the thesis's 40 ms, and the frame rate it calls that.
inline constexpr double thesis_frame_seconds = 0.040;
inline constexpr double frame_rate = 24;

/// The body of the workload with n cells per edge.
BodyConfig timing_cube(int n);

TimingConfig timing_config(const ExperimentOptions& options);

/// Measures method by method in turn, again and again, so that whatever disturbs the machine meets all of
/// them. A pass over a size that was not finished when `progress` said stop is left out.
TimingTables measure_timing(const TimingConfig& config, Progress& progress);

/// What features of a body cost beside each other, in turn, one thread.
struct FeatureTimingConfig {
  std::vector<int> cells{7, 20, 50};  ///< per edge
  int repetitions = 81;  ///< what they differ by is less than one sample's noise on a busy machine
  double sample_seconds = 2e-3;
};

/// Sizes that were not finished in a precision when `progress` said stop are left out there.
struct FeatureTables {
  /// Time of one step of the workload and of variants that have something more or less, a row each and size
  /// and precision, with its share of the workload's.
  Table features;
  /// Of those that lack something: time of one step over that of the same body with the sweep that serves any
  /// body. Median and quartiles of pairs of samples.
  Table lean;
};
/// The fastest kernel with nothing to choose from: its damped sweep of any body serves all unguarded ones.
template <class Real>
SweepKernel<Real> general_kernel();

FeatureTables measure_features(const FeatureTimingConfig& config, Progress& progress);
Chart features_chart(const Table& table);

/// For every method: exponent of time in n over the sizes from 20 on, and the largest n under 40 ms.
Table timing_summary(const Table& rows);

Chart timing_chart(const Table& rows, const Table& summary);

/// The summary as aligned lines, and what the best of each kind comes to against the best of the others.
std::string timing_text(const Table& rows, const Table& summary);

}  // namespace mss::studies::timing
