// What the sweep reaches of the processor's peaks, which are measured in the same run.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/base/thread_team.hpp"
#include "core/kernels/dispatch.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/studies/timing/peaks.hpp"
#include "experiments/studies/timing/timing.hpp"

namespace mss::studies::timing {

namespace {

constexpr const char *multiply_adds = "multiply_add", *triad = "triad";
constexpr double sample_seconds = 20e-3;
constexpr double widest_peak = 1.5;  ///< of a pass, between its best sample and its median
constexpr std::size_t triad_numbers = std::size_t{1} << 23;  // 64 MB an array, 192 MB in all

std::string precision_name(bool single) { return single ? "single" : "double"; }

/// The highest rate of a few samples, as whatever disturbs one makes a peak too low, and nothing makes it too
/// high; and their median, which tells whether they were disturbed.
struct Rates {
  double highest, median;
};

Rates rates_of(double work, const std::function<double()>& sample) {
  std::vector<double> seconds;
  for (int repetition = 0; repetition < 5; ++repetition) seconds.push_back(sample());
  return {work / *std::min_element(seconds.begin(), seconds.end()), work / quantile(seconds, 0.5)};
}

/// flop/s of all threads together.
Rates multiply_add_rates(const MultiplyAdd& loop, ThreadTeam& team) {
  std::vector<double> results(std::size_t(team.size()));
  const auto seconds_for = [&](long rounds) {
    return seconds_of([&] {
      team.for_each(team.size(), [&](std::ptrdiff_t i) { results[std::size_t(i)] = loop.run(rounds); });
    });
  };
  const long rounds = sample_length(sample_seconds, seconds_for).steps;
  return rates_of(loop.flops * double(rounds) * double(team.size()), [&] { return seconds_for(rounds); });
}

/// B/s of all threads together.
Rates triad_rates(const PeakLoops& loops, ThreadTeam& team) {
  std::vector<double> a(triad_numbers), b(triad_numbers, 1), c(triad_numbers, 2);
  const auto ranks = std::size_t(team.size());
  const auto part = [&](std::ptrdiff_t rank) {
    const std::size_t begin = triad_numbers * std::size_t(rank) / ranks,
                      end = triad_numbers * (std::size_t(rank) + 1) / ranks;
    loops.triad(&a[begin], &b[begin], &c[begin], 3, std::ptrdiff_t(end - begin));
  };
  return rates_of(24 * double(triad_numbers),
                  [&] { return seconds_of([&] { team.for_each(team.size(), part); }); });
}

/// The largest and the smallest of the passes, and the largest median of samples of a pass; NaN if there are
/// none.
struct PeakRange {
  double highest, lowest, median;
  /// Whether the samples of one pass at least agree: nothing disturbed them.
  bool is_sound() const { return median >= highest / widest_peak; }
};
PeakRange peak(const Table& peaks, const char* quantity, const std::string& precision, double threads) {
  const Table rows =
      peaks.where("quantity", quantity).where("precision", precision).where("threads", threads);
  PeakRange range{no_value, no_value, no_value};
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double rate = rows.number(r, "rate");
    range = {std::fmax(range.highest, rate), std::fmin(range.lowest, rate),
             std::fmax(range.median, rows.number(r, "median_rate"))};
  }
  return range;
}

struct Share {
  double value;
  std::string status = "ok";
};

Share share(double rate, const PeakRange& peak, double other_work) {
  if (std::isnan(peak.highest)) return {no_value, "peaks not measured"};
  if (other_work >= spoiling_share) return {no_value, "withheld: " + beside_text(other_work)};
  if (!peak.is_sound())
    return {no_value, fmt::format("withheld: samples of a peak differ by a factor of {:.1f}",
                                  peak.highest / peak.median)};
  if (rate > peak.highest)
    return {no_value, fmt::format("withheld: {:.2f} times a measured peak", rate / peak.highest)};
  return {rate / peak.highest};
}

}  // namespace

Table empty_peaks() {
  return Table({{"pass"},
                {"quantity"},
                {"instruction_set"},
                {"precision"},
                {"threads"},
                {"rate", "1/s"},
                {"median_rate", "1/s"}});
}

void add_peaks(int pass, const std::vector<int>& threads, Table& peaks) {
  const PeakLoops loops = fastest_copy<PeakLoops>();
  for (const int count : threads) {
    ThreadTeam team(count);
    const auto add = [&](const char* quantity, bool single, const Rates& rates) {
      peaks.add({pass, quantity, loops.instruction_set, precision_name(single), count, rates.highest,
                 rates.median});
    };
    for (const bool single : {false, true})
      add(multiply_adds, single, multiply_add_rates(single ? loops.in_single : loops.in_double, team));
    add(triad, false, triad_rates(loops, team));
  }
}

/// A spring: differences of places and velocities 6, squared length and projected speed 10, reciprocal root
/// 6, stiffness and damping 5, force 3, its addition to both ends 6. A cell: sums of diagonals 12, mean edges
/// 9, faces 27, volume 6, pressure 2, forces 27, their addition to those of the body diagonals 12. A
/// particle: sum with the plane below 3, acceleration 6, velocity 6, place 6. What a kernel computes beside
/// these (shares of springs at the surface, a second step of the reciprocal root, empty lanes) does not
/// count.
double flops_per_step(double springs, double cells, double particles) {
  return 36 * springs + 95 * cells + 21 * particles;
}

double bytes_per_step(double particles, bool single) { return 14 * (single ? 4 : 8) * particles; }

Table timing_limits(const Table& rows, const Table& peaks, double other_work) {
  Table limits({{"precision"},
                {"threads"},
                {"cells"},
                {"instruction_set"},
                {"seconds_per_step", "s"},
                {"flops_per_step"},
                {"peak_flops", "1/s"},
                {"lowest_peak_flops", "1/s"},
                {"share_of_peak"},
                {"bytes_per_step", "B"},
                {"bandwidth", "B/s"},
                {"lowest_bandwidth", "B/s"},
                {"share_of_bandwidth"},
                {"status"},
                {"q3_over_q1"}});
  if (peaks.size() == 0) return limits;
  const Table sweeps = rows.where("method", "structured_sweep").where("status", "ok");
  for (std::size_t r = 0; r < sweeps.size(); ++r) {
    const std::string& precision = sweeps.text(r, "precision");
    const double threads = sweeps.number(r, "threads"), n = sweeps.number(r, "cells"),
                 particles = sweeps.number(r, "particles"), seconds = sweeps.number(r, "seconds_per_step");
    const double flops = flops_per_step(sweeps.number(r, "springs"), n * n * n, particles),
                 bytes = bytes_per_step(particles, precision == precision_name(true));
    const PeakRange fused = peak(peaks, multiply_adds, precision, threads),
                    stream = peak(peaks, triad, precision_name(false), threads);
    const Share of_peak = share(flops / seconds, fused, other_work),
                of_bandwidth = share(bytes / seconds, stream, other_work);
    limits.add({precision, std::int64_t(threads), std::int64_t(n), peaks.text(0, "instruction_set"), seconds,
                flops, fused.highest, fused.lowest, of_peak.value, bytes, stream.highest, stream.lowest,
                of_bandwidth.value, of_peak.status == "ok" ? of_bandwidth.status : of_peak.status,
                spread_of(sweeps, r)});
  }
  return limits;
}

std::string limits_text(const Table& limits) {
  std::string text;
  for (std::size_t r = 0; r < limits.size(); ++r) {
    const double n = limits.number(r, "cells");
    if (n != 7 && n != 20 && n != 50) continue;
    const double spread = limits.number(r, "q3_over_q1");
    if (limits.text(r, "status").starts_with("withheld") || spread > widest_quartiles) {
      const std::string reason =
          spread > widest_quartiles ? "withheld: " + spread_text(spread) : limits.text(r, "status");
      text += fmt::format("n = {}, {}, threads: {}: {}\n", n, limits.text(r, "precision"),
                          limits.number(r, "threads"), reason);
      continue;
    }
    text += fmt::format(
        "n = {}, {}, threads: {}: {:.2f} of the measured peak of multiply-adds ({:.0f} Gflop/s), {:.2f} of "
        "the "
        "memory bandwidth ({:.0f} GB/s)\n",
        n, limits.text(r, "precision"), limits.number(r, "threads"), limits.number(r, "share_of_peak"),
        1e-9 * limits.number(r, "peak_flops"), limits.number(r, "share_of_bandwidth"),
        1e-9 * limits.number(r, "bandwidth"));
  }
  return text.empty() ? text
                      : "\nThe sweep beside this processor's limits, measured in the same run:\n" + text;
}

}  // namespace mss::studies::timing
