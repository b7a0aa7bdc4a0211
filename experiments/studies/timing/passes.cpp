// How much times differ between passes: what interleaving cannot average out.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "experiments/studies/timing/timing.hpp"

namespace mss::studies::timing {

namespace {

/// One row of the table; nothing if there is a single pass.
void add_case(Table& passes, const Table& samples) {
  const std::vector<double> numbers = samples.distinct_numbers("pass");
  if (numbers.size() < 2) return;
  double fastest = std::numeric_limits<double>::infinity(), slowest = 0;
  for (const double pass : numbers) {
    const Table of_pass = samples.where("pass", pass);
    std::vector<double> times;
    for (std::size_t r = 0; r < of_pass.size(); ++r) times.push_back(of_pass.number(r, "seconds_per_step"));
    const double median = quartiles(times).median;
    fastest = std::min(fastest, median);
    slowest = std::max(slowest, median);
  }
  passes.add({samples.text(0, "method"), samples.text(0, "precision"),
              std::int64_t(samples.number(0, "threads")), std::int64_t(samples.number(0, "cells")),
              std::int64_t(numbers.size()), fastest, slowest, slowest / fastest});
}

std::string name_of(const Table& passes, std::size_t r) {
  return fmt::format("{} {}, threads: {}, n = {}", passes.text(r, "method"), passes.text(r, "precision"),
                     passes.number(r, "threads"), passes.number(r, "cells"));
}

}  // namespace

Table timing_passes(const Table& raw) {
  Table passes({{"method"},
                {"precision"},
                {"threads"},
                {"cells"},
                {"passes"},
                {"fastest", "s"},
                {"slowest", "s"},
                {"slowest_over_fastest"}});
  for (const std::string& method : raw.distinct("method")) {
    const Table of_method = raw.where("method", method);
    for (const std::string& precision : of_method.distinct("precision")) {
      const Table of_precision = of_method.where("precision", precision);
      for (const double threads : of_precision.distinct_numbers("threads")) {
        const Table curve = of_precision.where("threads", threads);
        for (const double cells : curve.distinct_numbers("cells"))
          add_case(passes, curve.where("cells", cells));
      }
    }
  }
  return passes;
}

std::string passes_text(const Table& passes) {
  if (passes.size() == 0) return {};
  std::vector<double> spreads;
  std::size_t worst = 0;
  for (std::size_t r = 0; r < passes.size(); ++r) {
    spreads.push_back(passes.number(r, "slowest_over_fastest"));
    if (spreads[r] > spreads[worst]) worst = r;
  }
  const Quartiles spread = quartiles(spreads);
  return fmt::format(
      "\nNoise: medians of the same case in different passes differ by a factor of {:.2f} in half of the {} "
      "cases, {:.2f} in three quarters, and {:.2f} at most ({}); smaller differences between methods mean "
      "nothing\n",
      spread.median, passes.size(), spread.q3, spreads[worst], name_of(passes, worst));
}

}  // namespace mss::studies::timing
