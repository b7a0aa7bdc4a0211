#pragma once

#include <string>
#include <vector>

#include "core/body/body.hpp"
#include "experiments/harness/experiment.hpp"

// `mss timing --devices`: steps on devices beside the processor's.

namespace mss::studies::timing {

/// A device whose steps are timed.
struct TimedDevice {
  std::string choice;        ///< as `solve.device` names it
  std::string name;          ///< as its driver calls it
  bool is_software = false;  ///< its shaders run on the processor
};

/// Every card that can be used, or else the first device that computes in software. Throws
/// InputError if there is none.
std::vector<TimedDevice> timed_devices();

/// Bytes that a device reads and writes in a second while it copies a buffer larger than its caches, the
/// median of a few samples.
double copy_bandwidth(const TimedDevice& device);

/// The most cells per edge, between `fits` and `most`, of a cube whose vectors in single precision a device
/// has memory for; one with `fits` is known to fit.
int largest_cube_on(const TimedDevice& device, int fits, int most);

/// Settings of `mss timing --devices`.
struct DeviceTimingConfig {
  std::vector<int> cells;           ///< per edge, ascending
  std::vector<int> threads{1};      ///< of the processor
  std::vector<int> method_cells{};  ///< at which other methods than semi-implicit Euler are timed too
  int repetitions = 7;
  double sample_seconds = 20e-3;    ///< of a sample, which consists of several steps
  double seconds_per_row = 4;       ///< a size that would take longer, check included, is left out
  double seconds_for_largest = 40;  ///< to prepare the largest cube that fits on a card; 0: none
};

DeviceTimingConfig device_timing_config(const ExperimentOptions& options);

struct DeviceTables {
  /// One row per device, precision, number of threads, method and size, those of a size interleaved.
  Table rows;
  std::vector<std::string> notes = {};  ///< what was left out, and the largest cubes
  Status status = Status::ok;
};

DeviceTables measure_devices(const DeviceTimingConfig& config, const std::vector<TimedDevice>& devices,
                             Progress& progress);

/// How far particles are from where they should be after some steps from `start`: the largest distance over
/// the longest way, which must not be 0. NaN if a number in `found` is not finite.
template <class Real>
double error_over_motion(const Body& body, const State<double>& start, const State<double>& expected,
                         const State<Real>& found);

/// The error up to which a time is written.
constexpr double allowed_error(bool single) { return single ? 1e-4 : 1e-10; }

/// Bytes that a step must move at least: places and velocities read and written once each, and the kind of
/// every particle read once.
constexpr double least_bytes_per_step(double particles, bool single) {
  return (4 * 3 * (single ? 4 : 8) + 4) * particles;
}

/// The status of a row without a time.
inline constexpr const char* wrong_motion = "wrong";
inline bool is_right(double error, bool single) { return error <= allowed_error(single); }  // NaN is not

/// For every device and precision its highest rate with semi-implicit Euler, and the cells per edge from
/// which on it is faster than two threads of the processor: where lines between measured sizes cross (both
/// axes logarithmic), `how` = "interpolated"; or the smallest size, "every size"; or NaN, and why.
Table devices_summary(const Table& rows, double other_work = 0);
std::string devices_text(const Table& rows, const Table& summary);

/// The summary of `timing` for devices and the processor.
Table devices_time(const Table& rows, double other_work = 0);

/// Rates, and times as `timing` has them, against resolution.
Drawings draw_devices(const Table& rows, const Table& time);

/// What `mss timing --devices` is.
ExperimentResult run_devices(const ExperimentOptions& options, Progress& progress);

}  // namespace mss::studies::timing
