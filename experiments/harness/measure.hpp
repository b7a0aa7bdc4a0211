#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <vector>

#include "experiments/harness/progress.hpp"
#include "experiments/harness/statistics.hpp"
#include "experiments/harness/table.hpp"
#include "integrators/integrator.hpp"

// Measurement of wall time, for all experiments.

namespace mss {

/// Wall time since it was made.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point begin_ = Clock::now();
};

/// Seconds that a task takes.
template <class Task>
double seconds_of(Task&& task) {
  const Stopwatch watch;
  task();
  return watch.seconds();
}

/// Runs task(0) ... task(count - 1) in turn, `repetitions` times, the first one changing from round to round,
/// so that whatever disturbs the machine affects all of them alike. False if stopped on the way.
bool interleave(int repetitions, std::size_t count, const Progress& progress,
                const std::function<void(std::size_t)>& task);

/// The same for tasks that return a sample each: samples by task. Samples not taken when it was stopped
/// are missing.
std::vector<std::vector<double>> measure_interleaved(int repetitions, std::size_t count,
                                                     const Progress& progress,
                                                     const std::function<double(std::size_t)>& sample);

/// How many steps last about `seconds`, at least one, and what each of them takes.
struct SampleLength {
  long steps;
  double seconds_per_step;
};
/// `seconds_for` takes that many steps and returns their duration. The number is doubled until the quicker
/// of two takes half of `seconds`: one disturbed moment does not make a sample of a single step.
SampleLength sample_length(double seconds, const std::function<double(long)>& seconds_for);

/// Columns of what Work counts, and a row's cells for them.
std::vector<Column> work_columns();
std::vector<Cell> work_cells(const Work& work);

}  // namespace mss
