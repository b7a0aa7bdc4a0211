#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/body/body.hpp"
#include "core/kernels/sweep.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/studies/timing/workload.hpp"

namespace mss::studies::timing {

/// Settings of `mss timing`: the time of one update of a cube against its cells per edge, for every method.
struct TimingConfig {
  std::vector<int> cells;  ///< per edge, ascending
  std::vector<int> algorithm1_threads{1, 2, 8};
  std::vector<int> core_threads{1};
  /// Over all sizes, up and down in turn, so that slow changes of the machine's speed over minutes affect all
  /// sizes alike and do not bias exponents.
  int passes = 2;
  int repetitions = 8;           ///< samples per method and size, over all passes
  double sample_seconds = 4e-3;  ///< duration of a sample, which consists of several updates
  /// Large bodies get fewer repetitions to stay near this, but at least fewest_repetitions.
  double seconds_per_size = 3;
  int fewest_repetitions = 5;
  int largest_algorithm1 = 100;  ///< cells per edge up to which Algorithm 1 is built: it needs 1.5 GB there
  int largest_debug_build = 12;  ///< cells per edge up to which its debug build is run; 0: not at all
};

struct TimingTables {
  Table rows;   ///< one per method and size
  Table raw;    ///< one per sample, in the order they were taken
  Table peaks;  ///< what the processor can do, one row per pass, quantity, precision and number of threads
  Status status = Status::ok;
};

/// The thesis's time of a frame [s], and the frame rate it states for it [1/s].
inline constexpr double thesis_frame_seconds = 0.040;
inline constexpr double frame_rate = 24;

/// What is concluded from times is withheld where their quartiles are further apart than this factor: at the
/// exponent 3 of a cube it is 26 percent in cells per edge, and ratios of such times are only noise. Samples
/// of all passes are pooled, so that passes which disagree widen the quartiles too.
inline constexpr double widest_quartiles = 2;
/// An exponent is withheld where quartiles leave it a wider range than this: it could not tell a time that
/// grows as the volume does, 3, from one half-way to the surface's, 2.5.
inline constexpr double widest_exponent_range = 0.5;

/// From this share of the cores that other work took on, fits, sizes, ratios and shares of peaks are withheld
/// whatever the quartiles are: all samples may have been disturbed alike, as those of threads that wait for
/// each other are. It is half a core of two.
inline constexpr double spoiling_share = 0.25;

/// How far quartiles are apart, as a factor; NaN if there is no sample.
double spread_of(const Table& rows, std::size_t row, const char* q1 = "q1", const char* q3 = "q3");
/// As "other work took 31 % of the cores".
std::string beside_text(double other_work);
/// As "quartiles a factor of 3.1 apart".
std::string spread_text(double spread);
/// The notice of a chart of ratios that are not withheld; empty if quartiles of none are too far apart.
std::string spread_notice(const Table& rows, const char* q1, const char* q3);

TimingConfig timing_config(const ExperimentOptions& options);

/// Interleaves the samples of all methods, so that disturbances of the machine affect all of them alike. A
/// pass over a size that was not complete when it was stopped is left out.
TimingTables measure_timing(const TimingConfig& config, Progress& progress);

/// Samples by the program mss_debug_build of the plain loop and, with each number of threads, of Algorithm 1:
/// columns method, threads, steps and seconds_per_step; no rows if it is not there or fails.
Table debug_build_samples(int cells, int samples, double sample_seconds, const std::vector<int>& threads);

/// What it is compiled with, last.
const char* debug_build_flags();

/// Columns of TimingTables::peaks, and what one pass adds: fused multiply-adds on registers by the fastest
/// instruction set, in double and single precision [flop/s], and the triad a = b + s c over arrays far larger
/// than the caches [B/s; 24 a number], with each number of threads. The rate is the best of a few samples,
/// beside their median.
Table empty_peaks();
void add_peaks(int pass, const std::vector<int>& threads, Table& peaks);

/// Floating-point operations that a step of a damped body with volume forces needs; see the definition.
double flops_per_step(double springs, double cells, double particles);
/// Bytes of the arrays that a step of the sweep reads and writes, once each: 14 numbers a particle.
double bytes_per_step(double particles, bool single);

/// Of the structured sweep: its work over its time and over the highest peak of the passes, how much of the
/// processor's peaks in the same run it reaches. That is withheld where it is above 1, or where the samples
/// that the peak is the best of disagree: it was disturbed; or
/// where other work took so large a share of the cores that all samples may have been.
Table timing_limits(const Table& rows, const Table& peaks, double other_work = 0);
std::string limits_text(const Table& limits);

/// For every method and size, the smallest and largest median of a pass, and their ratio.
Table timing_passes(const Table& raw);
std::string passes_text(const Table& passes);

/// Settings of the comparison of features of a body, interleaved, on one thread.
struct FeatureTimingConfig {
  std::vector<int> cells{7, 20, 50};  ///< per edge
  int repetitions = 9;  ///< many: differences are smaller than the noise of one sample on a busy machine
  double sample_seconds = 2e-3;
};

/// Sizes that were not complete in a precision when it was stopped are left out there.
struct FeatureTables {
  /// Time of one step of the workload and of variants with one feature more or less, and its ratio to the
  /// workload's; a row per variant, size and precision.
  Table features;
  /// Of variants without a feature: time of one step, divided by that of the same body with the general
  /// sweep. Median and quartiles over pairs of samples.
  Table lean;
};
/// The fastest kernel, but with its damped sweep for any body in the place of all unguarded ones.
template <class Real>
SweepKernel<Real> general_kernel();

FeatureTables measure_features(const FeatureTimingConfig& config, Progress& progress);
Chart features_chart(const Table& table);

/// Settings of the comparison of a ball and of a random body with a box of as many cells per edge, on one
/// thread.
struct ShapeTimingConfig {
  std::vector<int> cells{20, 33, 40};  ///< per edge
  int repetitions = 15;
  double sample_seconds = 10e-3;
};

/// Time per particle of a step of the workload and of a tangent product, and its ratio to the box's: median
/// and quartiles over pairs of samples; a row per body, operation, precision and size. Sizes that were not
/// complete in a precision when it was stopped are left out there.
Table measure_shapes(const ShapeTimingConfig& config, Progress& progress);
Chart shapes_chart(const Table& table);

/// Settings of the comparison of engines' methods with an explicit step.
struct MethodTimingConfig {
  std::vector<int> cells{7, 20, 50};  ///< per edge
  std::vector<int> threads{1};
  int repetitions = 5;
  double sample_seconds = 10e-3;
};

/// Time of an iteration with its share of the step, and its ratio to a step of semi-implicit Euler of the
/// same precision: median and quartiles over pairs of samples; a row per method, precision, number of threads
/// and size. Sizes that were not complete in a precision when it was stopped are left out there.
Table measure_methods(const MethodTimingConfig& config, Progress& progress);
Chart methods_chart(const Table& table);

/// The step that a method of that table is timed at [s]; NaN of a method that this version does not know.
double step_of_method(const std::string& method);

/// Settings of the comparison with other programs.
struct PeerTimingConfig {
  std::vector<int> cells{7, 20, 50};  ///< per edge
  std::vector<int> threads{1};        ///< of ours, 1 among them
  int repetitions = 7;
  double sample_seconds = 20e-3;
};

/// The step that they are asked for [s]; one takes as long whatever it is.
inline constexpr double peer_step = 1.0 / 60;

/// Time of one step of the same particles and springs in other programs as they come, over that of ours with
/// the faster number of threads and with one: medians and quartiles over pairs of samples; a row per program,
/// size and precision of ours. What is not installed has a row that says so.
Table measure_peers(const PeerTimingConfig& config, Progress& progress);
/// Its rows as lines.
std::string peers_text(const Table& table);

/// The step of semi-implicit Euler on the workload with n cells per edge that dt = "safe" stands for [s].
double safe_step(int n);

/// What a simulated second costs on one thread: a row for every method, precision and size of the tables
/// `timing`, `timing_methods` and, where there is one, `timing_peers`. Its time is that of a step, all its
/// iterations together, over the step size: the safe step of semi-implicit Euler, and of other methods and
/// programs the one they are timed at. How accurate these are is not in it.
Table timing_seconds(const std::vector<NamedTable>& tables);
Chart seconds_chart(const Table& seconds);
/// Its rows as lines. Times whose quartiles are too far apart are withheld.
std::string seconds_text(const Table& seconds);

/// Springs a second of the methods of `timing`, beside what others published for their programs.
Chart rates_chart(const Table& rows);

/// A method as charts name it.
std::string method_name(const std::string& method);
/// The axis of cells per edge of sizes from `first` to `last`.
ChartAxis cells_axis(double first, double last);

/// The charts of the experiment.
Drawings draw_timing(const std::vector<NamedTable>& tables);

/// For every method: exponent of time in n over the sizes from 20 on, with its range by the quartiles, and
/// the largest n under 40 ms. Either is withheld where quartiles are too wide, or
/// other work took too much; the status says so.
Table timing_summary(const Table& rows, double other_work = 0);

Chart timing_chart(const Table& rows, const Table& summary);

/// The summary as aligned lines, and a comparison of the best times of each method.
std::string timing_text(const Table& rows, const Table& summary, double other_work = 0);

}  // namespace mss::studies::timing
