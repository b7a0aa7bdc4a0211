#include "experiments/harness/measure.hpp"

#include <algorithm>
#include <cmath>

namespace mss {

bool interleave(int repetitions, std::size_t count, const Progress& progress,
                const std::function<void(std::size_t)>& task) {
  for (int repetition = 0; repetition < repetitions; ++repetition)
    for (std::size_t i = 0; i < count; ++i) {
      if (progress.stopped()) return false;
      task((i + std::size_t(repetition)) % count);
    }
  return true;
}

std::vector<std::vector<double>> measure_interleaved(int repetitions, std::size_t count,
                                                     const Progress& progress,
                                                     const std::function<double(std::size_t)>& sample) {
  std::vector<std::vector<double>> samples(count);
  interleave(repetitions, count, progress, [&](std::size_t i) { samples[i].push_back(sample(i)); });
  return samples;
}

SampleLength sample_length(double seconds, const std::function<double(long)>& seconds_for) {
  const auto quickest_of_two = [&](long steps) { return std::min(seconds_for(steps), seconds_for(steps)); };
  long steps = 1;
  double elapsed = quickest_of_two(steps);
  while (elapsed < seconds / 2) {
    steps *= 2;
    elapsed = quickest_of_two(steps);
  }
  const double each = elapsed / double(steps);
  return {std::max(1L, std::lround(seconds / each)), each};
}

std::vector<Column> work_columns() {
  return {{"steps"},          {"force_evaluations"}, {"jacobians"},
          {"factorisations"}, {"linear_solves"},     {"products"}};
}

std::vector<Cell> work_cells(const Work& work) {
  return {work.steps,          work.force_evaluations, work.jacobians,
          work.factorisations, work.linear_solves,     work.products};
}

}  // namespace mss
