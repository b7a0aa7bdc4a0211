// The timing experiment on bodies too small to time: its rows, not its numbers.
#include "experiments/studies/timing/timing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/body/spectral_bound.hpp"
#include "core/kernels/dispatch.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/timing/peaks.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "reference/bullet_cube.hpp"
#include "reference/published_rates.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::timing {
namespace {

TimingConfig tiny() {
  TimingConfig config;
  config.cells = {2, 3};
  config.algorithm1_threads = {1, 2};
  config.core_threads = {1, 2};
  config.passes = 1;
  config.repetitions = 3;
  config.fewest_repetitions = 2;
  config.sample_seconds = 1e-5;
  config.seconds_per_size = 1e9;  // however busy the machine, no repetition is left out
  config.largest_debug_build = 0;
  return config;
}

constexpr std::size_t methods_of_tiny = 9;

std::vector<std::string> names(const Table& table) {
  std::vector<std::string> all;
  for (const Column& column : table.columns()) all.push_back(column.name);
  return all;
}

TEST(Timing, ColumnsBeginAsScriptsExpectThem) {
  Progress silent;
  const std::vector<std::string> columns = names(measure_timing(tiny(), silent).rows);
  const std::vector<std::string> contract{"method", "integrator", "precision", "threads",
                                          "cells",  "particles",  "springs",   "seconds_per_step",
                                          "q1",     "q3",         "repeats",   "status"};
  ASSERT_GE(columns.size(), contract.size());
  EXPECT_TRUE(std::equal(contract.begin(), contract.end(), columns.begin()));
}

TEST(Timing, HasARowForEveryMethodAndSize) {
  Progress silent;
  const TimingTables tables = measure_timing(tiny(), silent);
  EXPECT_EQ(tables.status, Status::ok);
  ASSERT_EQ(tables.rows.size(), 2 * methods_of_tiny);
  EXPECT_EQ(tables.raw.size(), 2 * methods_of_tiny * 3);
  std::vector<std::string> methods;
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    const Table& t = tables.rows;
    if (r < methods_of_tiny)
      methods.push_back(t.text(r, "method") + " " + t.text(r, "precision") + " " +
                        std::to_string(int(t.number(r, "threads"))));
    EXPECT_EQ(t.text(r, "status"), "ok");
    EXPECT_EQ(t.text(r, "integrator"), "semi_implicit_euler");
    EXPECT_EQ(t.number(r, "cells"), r < methods_of_tiny ? 2 : 3);
    EXPECT_EQ(t.number(r, "particles"), r < methods_of_tiny ? 27 : 64);
    EXPECT_EQ(t.number(r, "springs"), r < methods_of_tiny ? 158 : 468);  // 3n(n+1)^2 + 6n^2(n+1) + 4n^3
    EXPECT_EQ(t.number(r, "repeats"), 3);
    EXPECT_GE(t.number(r, "threads_working"), 1);
    EXPECT_LE(t.number(r, "threads_working"), t.number(r, "threads"));
    EXPECT_GT(t.number(r, "seconds_per_step"), 0);
    // 12 a spring and 24 a cell of 8 and of 27
    EXPECT_EQ(t.number(r, "atomic_additions"), t.text(r, "method") != "algorithm_1" ? 0
                                               : r < methods_of_tiny                ? 12 * 158 + 24 * 8
                                                                                    : 12 * 468 + 24 * 27);
    EXPECT_LE(t.number(r, "q1"), t.number(r, "seconds_per_step"));
    EXPECT_GE(t.number(r, "q3"), t.number(r, "seconds_per_step"));
  }
  EXPECT_EQ(methods,
            (std::vector<std::string>{"algorithm_1 double 1", "algorithm_1 double 2", "plain_loop double 1",
                                      "plain_loop double 2", "plain_loop single 1",
                                      "structured_sweep double 1", "structured_sweep double 2",
                                      "structured_sweep single 1", "structured_sweep single 2"}));
}

TEST(Timing, SaysWhyAMethodWasSkipped) {
  Progress silent;
  TimingConfig config = tiny();
  config.largest_algorithm1 = 2;
  const Table rows = measure_timing(config, silent).rows;
  int skipped = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows.text(r, "status") == "ok") continue;
    EXPECT_EQ(rows.text(r, "status"), "skipped: too large");
    EXPECT_EQ(rows.number(r, "cells"), 3);
    EXPECT_EQ(rows.number(r, "repeats"), 0);
    EXPECT_TRUE(std::isnan(rows.number(r, "seconds_per_step")));
    ++skipped;
  }
  EXPECT_EQ(skipped, 5);
}

/// Stops from the given call of stopped() on.
class StopAt final : public Progress {
 public:
  explicit StopAt(int call) : left_(call) {}
  bool stopped() const override { return --left_ < 0; }

 private:
  mutable int left_;
};

TEST(Timing, KeepsFinishedSizesWhenStopped) {
  // stopped() is called twice before the first size, once before others, before each of 9 calibrations,
  // before each of 3 x 9 samples, and at the end: 39 times for the first size.
  StopAt in_second(44);
  const TimingTables tables = measure_timing(tiny(), in_second);
  EXPECT_EQ(tables.status, Status::interrupted);
  ASSERT_EQ(tables.rows.size(), methods_of_tiny);
  EXPECT_EQ(tables.raw.size(), 3 * methods_of_tiny);
  for (std::size_t r = 0; r < tables.rows.size(); ++r) EXPECT_EQ(tables.rows.number(r, "cells"), 2);
  StopAt at_once(0);
  EXPECT_EQ(measure_timing(tiny(), at_once).rows.size(), 0U);
}

TEST(Timing, PoolsPassesOverAllSizes) {
  TimingConfig config = tiny();
  config.passes = 3;
  config.repetitions = 6;
  Progress silent;
  const TimingTables tables = measure_timing(config, silent);
  ASSERT_EQ(tables.rows.size(), 2 * methods_of_tiny);
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    EXPECT_EQ(tables.rows.number(r, "cells"), r < methods_of_tiny ? 2 : 3);
    EXPECT_EQ(tables.rows.number(r, "repeats"), 6);
  }
  EXPECT_EQ(tables.raw.size(), 2 * methods_of_tiny * 6);
  std::vector<double> order;  // of (pass, size)
  for (std::size_t r = 0; r < tables.raw.size(); r += 2 * methods_of_tiny)
    order.push_back(tables.raw.number(r, "cells"));
  EXPECT_EQ(order, (std::vector<double>{2, 3, 3, 2, 2, 3}));
}

TEST(Timing, MeasuresADebugBuildOfTheThesissLoops) {
  Progress silent;
  TimingConfig config = tiny();
  config.cells = {4};
  config.largest_debug_build = 4;
  const Table rows = measure_timing(config, silent).rows;
  const Table debug = rows.where("method", "plain_loop_debug");
  ASSERT_EQ(debug.size(), 1U);
  EXPECT_EQ(debug.text(0, "status"), "ok");
  EXPECT_EQ(rows.where("method", "algorithm_1_debug").size(), 2U);
  EXPECT_GT(debug.number(0, "seconds_per_step"), 0);
}

/// Two cases, three passes: 1, 2, 4 s and 3, 3, 3 s, each the median of samples that differ.
TEST(TimingPasses, CompareMediansOfTheSameCase) {
  Table raw({{"method"}, {"precision"}, {"threads"}, {"cells"}, {"pass"}, {"seconds_per_step"}});
  for (int pass = 0; pass < 3; ++pass)
    for (const double factor : {0.5, 1.0, 9.0}) {
      raw.add({"loop", "double", 1, 7, pass, factor * double(1 << pass)});
      raw.add({"loop", "double", 1, 20, pass, 3.0});
    }
  const Table passes = timing_passes(raw);
  ASSERT_EQ(passes.size(), 2U);
  EXPECT_EQ(passes.number(0, "fastest"), 1);
  EXPECT_EQ(passes.number(0, "slowest"), 4);
  EXPECT_EQ(passes.number(0, "slowest_over_fastest"), 4);
  EXPECT_EQ(passes.number(1, "slowest_over_fastest"), 1);
  EXPECT_NE(passes_text(passes).find("4.00 at most (loop double, threads: 1, n = 7)"), std::string::npos);
}

/// A sweep that takes a second on a processor of twice its operations and four times its bytes per second.
TEST(TimingLimits, ShareIsWorkOverTimeOverPeak) {
  const double flops = 36.0 * 158 + 95 * 8 + 21 * 27, bytes = 14 * 8 * 27;
  EXPECT_EQ(flops_per_step(158, 8, 27), flops);
  Table rows({{"method"},
              {"precision"},
              {"threads"},
              {"cells"},
              {"particles"},
              {"springs"},
              {"seconds_per_step"},
              {"q1"},
              {"q3"},
              {"status"}});
  rows.add({"structured_sweep", "double", 1, 2, 27, 158, 1.0, 0.9, 1.1, "ok"});
  rows.add({"structured_sweep", "double", 2, 2, 27, 158, 1.0, 0.9, 1.1, "ok"});
  rows.add({"plain_loop", "double", 1, 2, 27, 158, 1.0, 0.9, 1.1, "ok"});
  Table peaks = empty_peaks();
  peaks.add({0, "multiply_add", "any", "double", 1, 2 * flops, 1.9 * flops});
  peaks.add({0, "triad", "any", "double", 1, 4 * bytes, 3.9 * bytes});
  const Table limits = timing_limits(rows, peaks);
  ASSERT_EQ(limits.size(), 2U);
  EXPECT_NEAR(limits.number(0, "share_of_peak"), 0.5, 1e-15);
  EXPECT_NEAR(limits.number(0, "share_of_bandwidth"), 0.25, 1e-15);
  EXPECT_EQ(limits.text(1, "status"), "peaks not measured");
}

/// A sweep of n = 7 that takes a second with these quartiles, beside peaks in units of its own rates.
Table limits_of(double q1, double q3, double peak, double median_peak, double other_work = 0) {
  const double flops = flops_per_step(5068, 343, 512), bytes = bytes_per_step(512, false);
  Table rows({{"method"},
              {"precision"},
              {"threads"},
              {"cells"},
              {"particles"},
              {"springs"},
              {"seconds_per_step"},
              {"q1"},
              {"q3"},
              {"status"}});
  rows.add({"structured_sweep", "double", 1, 7, 512, 5068, 1.0, q1, q3, "ok"});
  Table peaks = empty_peaks();
  peaks.add({0, "multiply_add", "any", "double", 1, peak * flops, median_peak * flops});
  peaks.add({0, "triad", "any", "double", 1, 4 * bytes, 4 * bytes});
  return timing_limits(rows, peaks, other_work);
}

TEST(TimingLimits, StateNoShareOfADisturbedPeak) {
  const Table sound = limits_of(0.9, 1.1, 2, 1.9);
  EXPECT_EQ(sound.text(0, "status"), "ok");
  EXPECT_NE(limits_text(sound).find("0.50 of the measured peak"), std::string::npos) << limits_text(sound);

  const Table above = limits_of(0.9, 1.1, 0.5, 0.49);  // nothing is faster than a peak
  EXPECT_TRUE(std::isnan(above.number(0, "share_of_peak")));
  EXPECT_NEAR(above.number(0, "share_of_bandwidth"), 0.25, 1e-15);
  EXPECT_EQ(above.text(0, "status"), "withheld: 2.00 times a measured peak");
  EXPECT_NE(limits_text(above).find("n = 7, double, threads: 1: withheld: 2.00 times"), std::string::npos)
      << limits_text(above);

  const Table disturbed = limits_of(0.9, 1.1, 4, 2);  // the best of its samples may have been disturbed too
  EXPECT_TRUE(std::isnan(disturbed.number(0, "share_of_peak")));
  EXPECT_EQ(disturbed.text(0, "status"), "withheld: samples of a peak differ by a factor of 2.0");

  const Table beside = limits_of(0.9, 1.1, 2, 1.9, 0.79);  // samples agree where all were disturbed alike
  EXPECT_TRUE(std::isnan(beside.number(0, "share_of_peak")));
  EXPECT_TRUE(std::isnan(beside.number(0, "share_of_bandwidth")));
  EXPECT_EQ(beside.text(0, "status"), "withheld: other work took 79 % of the cores");

  const Table wide = limits_of(0.5, 1.5, 2, 1.9);
  EXPECT_EQ(wide.number(0, "q3_over_q1"), 3);
  EXPECT_NE(limits_text(wide).find("withheld: quartiles a factor of 3.0 apart"), std::string::npos)
      << limits_text(wide);
}

/// However busy a processor is, none reaches a thousand operations a cycle, as loops would seem to that
/// compute nothing.
TEST(TimingLimits, MeasuresThePeaksOfThisProcessor) {
  Table peaks = empty_peaks();
  add_peaks(3, {1}, peaks);
  ASSERT_EQ(peaks.size(), 3U);
  const std::vector<std::pair<std::string, std::string>> measured{
      {"multiply_add", "double"}, {"multiply_add", "single"}, {"triad", "double"}};
  for (std::size_t r = 0; r < 3; ++r) {
    EXPECT_EQ(peaks.number(r, "pass"), 3);
    EXPECT_EQ(peaks.text(r, "quantity"), measured[r].first);
    EXPECT_EQ(peaks.text(r, "precision"), measured[r].second);
    EXPECT_GT(peaks.number(r, "rate"), 0);
    EXPECT_LT(peaks.number(r, "rate"), 1e13);
  }
}

/// Single precision has twice the lanes of double. Chains begin at 1, 1.01, ...; every round halves their
/// distance to 1, and their sum is returned.
TEST(TimingLimits, PeakLoopsComputeWhatTheyCount) {
  for (const PeakLoops& loops : runnable_copies<PeakLoops>()) {
    EXPECT_EQ(loops.in_single.flops, 2 * loops.in_double.flops) << loops.instruction_set;
    for (const long rounds : {0, 1, 5}) {
      const double expected = 12 + 0.01 * 66 / double(1 << rounds);
      EXPECT_NEAR(loops.in_double.run(rounds), expected, 1e-14 * 12) << loops.instruction_set;
      EXPECT_NEAR(loops.in_single.run(rounds), expected, 1e-5) << loops.instruction_set;
    }
    const std::vector<double> b{1, 2, 3}, c{4, 5, 6};
    std::vector<double> a(3);
    loops.triad(a.data(), b.data(), c.data(), 3, 3);
    EXPECT_EQ(a, (std::vector<double>{13, 17, 21})) << loops.instruction_set;
  }
}

ShapeTimingConfig tiny_shapes() { return {.cells = {2, 3}, .repetitions = 3, .sample_seconds = 1e-5}; }

TEST(Timing, DrawsFromItsFiles) {
  Progress silent;
  TimingConfig config = tiny();
  config.largest_algorithm1 = 2;
  const TimingTables tables = measure_timing(config, silent);
  const FeatureTables features =
      measure_features({.cells = {2}, .repetitions = 2, .sample_seconds = 1e-4}, silent);
  expect_same_drawings(find_experiment("timing"), {{"timing", tables.rows},
                                                   {"timing_summary", timing_summary(tables.rows)},
                                                   {"timing_features", features.features},
                                                   {"timing_lean", features.lean},
                                                   {"timing_shapes", measure_shapes(tiny_shapes(), silent)},
                                                   {"timing_raw", tables.raw}});
}

/// Rows of one method with seconds = a n^p, and quartiles that factor apart for the sizes of `wide`.
Table synthetic(const std::vector<int>& cells, double a, double p, double spread = 1,
                const std::vector<int>& wide = {}) {
  Table rows({{"method"},
              {"integrator"},
              {"precision"},
              {"threads"},
              {"cells"},
              {"springs"},
              {"seconds_per_step"},
              {"q1"},
              {"q3"},
              {"status"},
              {"ns_per_spring"}});
  for (const int n : cells) {
    const double s = a * std::pow(n, p);
    const bool is_wide = std::find(wide.begin(), wide.end(), n) != wide.end();
    const double half = is_wide ? std::sqrt(spread) : 1;
    rows.add({"plain_loop", "semi_implicit_euler", "double", std::int64_t{1}, std::int64_t{n},
              std::int64_t{16} * n * n * n, s, s / half, s * half, "ok", 1.0});
  }
  return rows;
}

TEST(TimingSummary, FitsTheSizesFromTwentyOn) {
  const Table summary = timing_summary(synthetic({5, 20, 30, 50}, 1e-7, 3.05));
  ASSERT_EQ(summary.size(), 1U);
  EXPECT_NEAR(summary.number(0, "exponent"), 3.05, 1e-12);
  EXPECT_EQ(summary.number(0, "fit_from"), 20);
  EXPECT_EQ(summary.number(0, "fit_to"), 50);
  EXPECT_EQ(summary.number(0, "fit_points"), 3);
  EXPECT_EQ(summary.text(0, "status"), "ok");
}

TEST(TimingSummary, FindsTheLargestBodyUnderForty) {
  // 1e-6 n^3 = 0.04 at n = 34.2: between 30 and 50.
  const Table between = timing_summary(synthetic({20, 30, 50}, 1e-6, 3));
  EXPECT_EQ(between.number(0, "largest_cells_40ms"), 34);
  EXPECT_EQ(between.text(0, "how"), "interpolated");
  // 1e-7 n^3 = 0.04 at n = 73.7: beyond 50.
  const Table beyond = timing_summary(synthetic({20, 30, 50}, 1e-7, 3));
  EXPECT_EQ(beyond.number(0, "largest_cells_40ms"), 73);
  EXPECT_EQ(beyond.text(0, "how"), "extrapolated");
  // 1e-10 n^3 = 0.04 at n = 737: too far to extrapolate.
  const Table far = timing_summary(synthetic({20, 30, 50}, 1e-10, 3));
  EXPECT_TRUE(std::isnan(far.number(0, "largest_cells_40ms")));
  EXPECT_NE(far.text(0, "status"), "ok");
}

TEST(TimingSummary, StatesAnExponentWithItsRange) {
  const Table summary = timing_summary(synthetic({20, 50}, 1e-7, 3, 1.2, {20, 50}));
  EXPECT_NEAR(summary.number(0, "exponent"), 3, 1e-12);
  const double half = std::log(1.2) / std::log(2.5);  // one end by half of it up, the other down
  EXPECT_NEAR(summary.number(0, "exponent_low"), 3 - half, 1e-12);
  EXPECT_NEAR(summary.number(0, "exponent_high"), 3 + half, 1e-12);
  EXPECT_EQ(summary.text(0, "status"), "ok");
}

/// Only quartiles tell it from the law: the medians lie on it.
TEST(TimingSummary, WithholdsAFitOfWideQuartiles) {
  const Table rows = synthetic({20, 30, 50}, 1e-7, 3, 4, {20});
  const Table summary = timing_summary(rows);
  EXPECT_TRUE(std::isnan(summary.number(0, "exponent")));
  EXPECT_TRUE(std::isnan(summary.number(0, "largest_cells_40ms")));  // by that fit
  EXPECT_EQ(summary.text(0, "how"), "withheld");
  EXPECT_EQ(summary.number(0, "fit_points"), 3);
  EXPECT_TRUE(summary.text(0, "status").starts_with("fit withheld: by the quartiles the exponent is 2."))
      << summary.text(0, "status");
  const std::string text = timing_text(rows, summary);
  EXPECT_NE(text.find("plain loop, 1 thread                  withheld               withheld"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("measure again on a quiet machine"), std::string::npos) << text;
  EXPECT_EQ(text.find("(fit)"), std::string::npos) << text;
  const Chart chart = timing_chart(rows, summary);
  EXPECT_EQ(chart.series.at(0).label, "plain loop, 1 thread: withheld");
  EXPECT_EQ(chart.notice, "Fits withheld for 1 of 1 methods: quartiles a factor of 4.0 apart");
}

/// 1e-6 n^3 = 0.04 at n = 34: between 30 and 50, which the noise at 20 cells says nothing about.
TEST(TimingSummary, KeepsASizeBetweenNarrowQuartiles) {
  const Table near = timing_summary(synthetic({20, 30, 50}, 1e-6, 3, 4, {20}));
  EXPECT_TRUE(std::isnan(near.number(0, "exponent")));
  EXPECT_EQ(near.number(0, "largest_cells_40ms"), 34);
  const Table rows = synthetic({7, 30, 50, 100}, 1e-6, 3, 2.2, {50});
  const Table far = timing_summary(rows);
  EXPECT_NEAR(far.number(0, "exponent"), 3, 1e-12);
  EXPECT_TRUE(std::isnan(far.number(0, "largest_cells_40ms")));
  EXPECT_EQ(far.text(0, "status"), "largest size withheld: quartiles a factor of 2.2 apart at n = 50");
  EXPECT_EQ(timing_chart(rows, far).series.at(0).label, "plain loop, 1 thread: 3.00, withheld");
}

TEST(TimingSummary, WithholdsNothingOfNarrowQuartiles) {
  const Table rows = synthetic({5, 20, 30, 50}, 1e-7, 3, 1.1, {5, 20, 30, 50});
  const Table summary = timing_summary(rows);
  EXPECT_EQ(summary.text(0, "status"), "ok");
  const Chart chart = timing_chart(rows, summary);
  EXPECT_EQ(chart.series.at(0).label, "plain loop, 1 thread: 3.00, ≈ 73");
  EXPECT_EQ(chart.notice, "");
  const std::string text = timing_text(rows, summary);
  EXPECT_EQ(text.find("withheld"), std::string::npos) << text;
  EXPECT_NE(text.find("ms at n = 50\n"), std::string::npos) << text;  // 1e-7 n^3; 7 cells were not measured
  EXPECT_NE(text.find(" 12.5\n"), std::string::npos) << text;
}

/// Samples that were all disturbed alike have narrow quartiles.
TEST(TimingSummary, WithholdsAllThatWasMeasuredBesideOtherWork) {
  const Table rows = synthetic({5, 20, 30, 50}, 1e-7, 3);
  EXPECT_EQ(timing_summary(rows, 0.2).text(0, "status"), "ok");
  const Table summary = timing_summary(rows, 0.75);
  EXPECT_TRUE(std::isnan(summary.number(0, "exponent")));
  EXPECT_TRUE(std::isnan(summary.number(0, "largest_cells_40ms")));
  EXPECT_EQ(summary.text(0, "status"),
            "fit withheld: other work took 75 % of the cores; largest size withheld: other work took 75 % of "
            "the cores");
  const std::string text = timing_text(rows, summary, 0.75);
  EXPECT_NE(text.find("withheld, and ratios of times too: other work took 75 % of the cores"),
            std::string::npos)
      << text;
  const Chart chart = timing_chart(rows, summary);
  EXPECT_EQ(chart.series.at(0).label, "plain loop, 1 thread: withheld");
  EXPECT_EQ(chart.notice, "Fits withheld for 1 of 1 methods");
}

TEST(TimingNotice, CountsRatiosThatAreNoise) {
  Table rows({{"q1"}, {"q3"}});
  rows.add({1.0, 1.9});
  EXPECT_EQ(spread_notice(rows, "q1", "q3"), "");
  rows.add({1.0, 3.0});
  EXPECT_EQ(spread_notice(rows, "q1", "q3"),
            "Too disturbed to compare: 1 of 2 points; one has quartiles a factor of 3.0 apart");
}

TEST(TimingSummary, SaysWhyThereIsNoFit) {
  const Table summary = timing_summary(synthetic({5, 7, 20}, 1e-7, 3));
  EXPECT_TRUE(std::isnan(summary.number(0, "exponent")));
  EXPECT_EQ(summary.text(0, "status"), "no fit: fewer than two sizes of 20 or more");
}

/// Lean sweeps leave out what is not there, and nothing else: the general sweep computes the same.
TEST(TimingFeatures, ComparesWithSweepsThatComputeTheSame) {
  const auto refill = [](BodyConfig& body, double face_share) {
    body.springs = calibrate(TimingWorkload::material, body.cell_size, face_share);
  };
  const std::vector<std::function<void(BodyConfig&)>> variants{
      [](BodyConfig& body) { body.damping = {}; }, [](BodyConfig& body) { body.springs.volume = 0; },
      [&](BodyConfig& body) { refill(body, 1); }, [&](BodyConfig& body) { refill(body, 0); },
      [&](BodyConfig& body) {
        refill(body, 1);
        body.springs.volume = 0;
        body.damping = {};
      }};
  for (const auto& change : variants) {
    BodyConfig config = timing_cube(4);
    change(config);
    const Body body(config);
    SpringSystem<double> chosen(body, {}), general(body, {}, general_kernel<double>(), {});
    const State<double> state = stretched_state(chosen, 1.2);
    Field<double> expected(body.lattice().size), force(body.lattice().size);
    general.force(0, state.x, state.v, expected);
    chosen.force(0, state.x, state.v, force);
    const double largest = expected.array().abs().maxCoeff();
    EXPECT_GT(largest, 0);
    EXPECT_LT((force.array() - expected.array()).abs().maxCoeff(), 1e-12 * largest) << &change - &variants[0];
  }
}

TEST(TimingFeatures, HasARowForEveryVariant) {
  Progress progress;
  const FeatureTables tables =
      measure_features({.cells = {2, 3}, .repetitions = 3, .sample_seconds = 1e-4}, progress);
  const Table& table = tables.features;
  EXPECT_EQ(table.size(), 9U * 2 * 2);
  for (std::size_t r = 0; r < table.size(); ++r) {
    EXPECT_EQ(table.text(r, "status"), "ok");
    EXPECT_GT(table.number(r, "seconds_per_step"), 0);
    if (table.text(r, "variant") == "workload") {
      EXPECT_EQ(table.number(r, "share"), 1);
    }
  }
  EXPECT_EQ(tables.lean.size(), 5U * 2 * 2);  // the workload's own sweep is the general one
  for (std::size_t r = 0; r < tables.lean.size(); ++r) EXPECT_GT(tables.lean.number(r, "over_general"), 0);
  const Chart chart = features_chart(table);
  EXPECT_EQ(chart.series.size(), 4U);
  EXPECT_EQ(chart.y.names.size(), 9U);
}

TEST(TimingShapes, HasARowForEveryBodyAndOperation) {
  Progress progress;
  const Table table = measure_shapes(tiny_shapes(), progress);
  ASSERT_EQ(table.size(), 3U * 2 * 2 * 2);
  EXPECT_EQ(table.distinct("body"), (std::vector<std::string>{"box", "ball", "random70"}));
  EXPECT_EQ(table.distinct("operation"), (std::vector<std::string>{"step", "tangent_product"}));
  for (std::size_t r = 0; r < table.size(); ++r) {
    EXPECT_EQ(table.text(r, "status"), "ok");
    EXPECT_EQ(table.number(r, "repeats"), 3);
    EXPECT_GT(table.number(r, "q1"), 0);
    EXPECT_LE(table.number(r, "q1"), table.number(r, "ns_per_particle"));
    EXPECT_LE(table.number(r, "ns_per_particle"), table.number(r, "q3"));
    EXPECT_LE(table.number(r, "over_box_q1"), table.number(r, "over_box"));
    EXPECT_LE(table.number(r, "over_box"), table.number(r, "over_box_q3"));
    if (table.text(r, "body") == "box") {
      EXPECT_EQ(table.number(r, "over_box"), 1);
    }
    if (table.text(r, "body") == "ball" && table.number(r, "cells") == 3) {
      EXPECT_EQ(table.number(r, "particles"), 64 - 8);  // a box without its corners
    }
  }
  const Chart chart = shapes_chart(table);
  ASSERT_EQ(chart.series.size(), 2U * 2 * 2);
  for (const ChartSeries& series : chart.series) EXPECT_EQ(series.points.size(), 2U) << series.label;
}

TEST(TimingShapes, KeepsFinishedSizesWhenStopped) {
  // stopped() is called before each of 3 samples of 3 bodies, of 2 operations in 2 precisions.
  StopAt in_second_size(3 * 3 * 2 * 2 + 5);
  const Table table = measure_shapes(tiny_shapes(), in_second_size);
  ASSERT_EQ(table.size(), 3U * 2 * 2);
  for (std::size_t r = 0; r < table.size(); ++r) EXPECT_EQ(table.number(r, "cells"), 2);
}

/// A step takes 1 us, but now and then a disturbance adds 4 ms.
TEST(SampleLength, IsNotChangedByAShortDisturbance) {
  int calls = 0;
  const SampleLength length = sample_length(1e-3, [&](long steps) {
    ++calls;
    return 1e-6 * double(steps) + (calls % 5 == 1 ? 4e-3 : 0);
  });
  EXPECT_EQ(length.steps, 1000);
  EXPECT_NEAR(length.seconds_per_step, 1e-6, 1e-12);
  EXPECT_EQ(sample_length(1e-3, [](long steps) { return 0.5 * double(steps); }).steps, 1);
}

TEST(TimingConfig, QuickTakesSomeOfTheSizesButTheLargest) {
  ExperimentOptions options;
  const std::vector<int> full = timing_config(options).cells;
  options.quick = true;
  const std::vector<int> quick = timing_config(options).cells;
  EXPECT_EQ(full, (std::vector{2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 20, 30, 50, 100}));
  EXPECT_TRUE(std::includes(full.begin(), full.end(), quick.begin(), quick.end()));
  EXPECT_EQ(quick, (std::vector{2, 3, 7, 11, 15, 20, 30}));
  options.cells = {4, 9};
  options.threads = 1;
  EXPECT_EQ(timing_config(options).cells, (std::vector{4, 9}));
  EXPECT_EQ(timing_config(options).core_threads, std::vector{1});
}

TEST(TimingMethods, ComparesIterationsWithAnExplicitStep) {
  Progress progress;
  const Table rows = measure_methods({.cells = {2}, .repetitions = 1, .sample_seconds = 1e-4}, progress);
  ASSERT_GT(rows.size(), 5U);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::string& method = rows.text(r, "method");
    EXPECT_EQ(rows.text(r, "status"), "ok") << method;
    EXPECT_GT(rows.number(r, "seconds_per_iteration"), 0) << method;
    EXPECT_EQ(rows.number(r, "iterations"), method == "vbd"                    ? 10
                                            : method == "backward_euler/lbfgs" ? 5
                                                                               : 1)
        << method;
    const Table step =
        rows.where("method", "semi_implicit_euler").where("precision", rows.text(r, "precision"));
    EXPECT_DOUBLE_EQ(rows.number(r, "over_explicit"),  // of the same precision
                     rows.number(r, "seconds_per_iteration") / step.number(0, "seconds_per_iteration"))
        << method;
  }
  EXPECT_EQ(methods_chart(rows).series.size(), 2U);  // double and single precision
}

TEST(TimingPeers, TimeBulletOrSayThatItIsMissing) {
  Progress progress;
  const Table rows = measure_peers({.cells = {2}, .repetitions = 1, .sample_seconds = 1e-4}, progress);
  if (reference::BulletCube::version().empty()) {
    ASSERT_EQ(rows.size(), 1U);
    EXPECT_EQ(rows.text(0, "status"), "not installed");
    return;
  }
  ASSERT_EQ(rows.size(), 2U);  // beside ours in single and in double precision
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "status"), "ok");
    EXPECT_EQ(rows.text(r, "our_precision"), r == 0 ? "single" : "double");
    EXPECT_GT(rows.number(r, "seconds_per_step"), 0);
    EXPECT_DOUBLE_EQ(rows.number(r, "over_ours"),
                     rows.number(r, "seconds_per_step") / rows.number(r, "our_seconds_per_step"));
    EXPECT_DOUBLE_EQ(rows.number(r, "over_ours_on_one_thread"),
                     rows.number(r, "seconds_per_step") / rows.number(r, "our_seconds_on_one_thread"));
  }
  const Body body(timing_cube(2));
  reference::BulletCube bullet(body, Vec3(0, 0, -10));
  for (int step = 0; step < 100; ++step) bullet.step(0.01);  // s = g t^2 / 2 = 5 m
  EXPECT_NEAR(bullet.position(0)[2] - body.rest_position(body.sites()[0])[2], -5, 0.2);
}

/// A step of Bullet takes 6 s, one of ours 3 s on one thread and 2 s on two.
Table peer_rows(double q3) {
  Table rows({{"program"},
              {"version"},
              {"precision"},
              {"cells"},
              {"seconds_per_step"},
              {"q1"},
              {"q3"},
              {"our_precision"},
              {"our_threads"},
              {"over_ours"},
              {"over_ours_q1"},
              {"over_ours_q3"},
              {"status"},
              {"over_ours_on_one_thread"},
              {"over_ours_on_one_thread_q1"},
              {"over_ours_on_one_thread_q3"}});
  for (const char* ours : {"single", "double"})
    rows.add({"Bullet", "3.24", "single", 7, 6.0, 5.5, 6.5, ours, 2, 3.0, 2.9, 3.1, "ok", 2.0, 1.9, q3});
  return rows;
}

TEST(TimingPeers, AreComparedOnOneThreadFirst) {
  const std::string text = peers_text(peer_rows(2.1));
  EXPECT_NE(
      text.find("Bullet 3.24 in single precision on one thread, n = 7: a step takes 6e+03 ms, 2.0 times "
                "ours in double on one thread, 3.0 times on 2\n"),
      std::string::npos)
      << text;
  EXPECT_NE(peers_text(peer_rows(4)).find("withheld"), std::string::npos);
}

/// It is computed on a small cube of the same cells.
TEST(TimingSeconds, SafeStepIsThatOfTheWholeCube) {
  for (const int n : {1, 2, 3, 7, 12}) {
    const SpectralBound bound = spectral_bound(Body(timing_cube(n)));
    const double whole = safe_share * stable_step(find_integrator("semi_implicit_euler"), bound);
    EXPECT_NEAR(safe_step(n), whole, 1e-12 * whole) << n;
  }
  EXPECT_NEAR(safe_step(14), safe_step(7) / 2, 1e-12);  // a step is as long as a wave takes through a cell
}

/// Of n = 7: a step of the sweep takes 1 ms, of the plain loop 4 ms and, with two threads, 2 ms; an iteration
/// of each other method 3 ms; quartiles are 0.9 and `q3` of medians.
std::vector<NamedTable> rows_of_seven(double q3 = 1.2) {
  Table loops({{"method"},
               {"integrator"},
               {"precision"},
               {"threads"},
               {"cells"},
               {"springs"},
               {"seconds_per_step"},
               {"q1"},
               {"q3"},
               {"status"},
               {"ns_per_spring"}});
  const auto add = [&](const char* method, int threads, double t) {
    loops.add({method, "semi_implicit_euler", "double", threads, 7, 5068, t, 0.9 * t, q3 * t, "ok", 1.0});
  };
  add("plain_loop", 1, 4e-3);
  add("plain_loop", 2, 2e-3);
  add("structured_sweep", 1, 1e-3);
  loops.add({"algorithm_1", "semi_implicit_euler", "double", 1, 7, 5068, no_value, no_value, no_value,
             "skipped: too large", no_value});
  Table methods({{"method"},
                 {"precision"},
                 {"iterations"},
                 {"threads"},
                 {"cells"},
                 {"seconds_per_iteration"},
                 {"q1"},
                 {"q3"},
                 {"over_explicit"},
                 {"over_explicit_q1"},
                 {"over_explicit_q3"},
                 {"status"}});
  const std::vector<std::pair<std::string, int>> timed{
      {"semi_implicit_euler", 1}, {"xpbd", 1}, {"vbd", 10}, {"gone", 1}};
  for (const auto& [method, iterations] : timed)
    for (const int threads : {1, 2})
      methods.add({method, "double", iterations, threads, 7, 3e-3, 2.7e-3, 3e-3 * q3, 1.0, 1.0, 1.0, "ok"});
  return {{"timing", loops},
          {"timing_summary", timing_summary(loops)},
          {"timing_methods", methods},
          {"timing_peers", peer_rows(2.1)}};
}

TEST(TimingSeconds, AreTheTimeOfAStepOverTheStepOnOneThread) {
  const Table seconds = timing_seconds(rows_of_seven());
  const std::vector<std::string> methods{
      "plain_loop", "structured_sweep", "algorithm_1", "xpbd", "vbd", "gone", "Bullet"};
  ASSERT_EQ(seconds.distinct("method"), methods);
  ASSERT_EQ(seconds.size(),
            methods.size());  // each once: of one thread alone, and of Bullet beside both of ours
  const double dt = safe_step(7);
  const auto expect = [&](std::size_t r, const char* step, double steps, double per_step) {
    EXPECT_EQ(seconds.text(r, "step"), step);
    EXPECT_EQ(seconds.number(r, "threads"), 1);
    EXPECT_NEAR(seconds.number(r, "dt"), 1 / steps, 1e-15);
    EXPECT_NEAR(seconds.number(r, "steps_per_second"), steps, 1e-9);
    EXPECT_NEAR(seconds.number(r, "seconds_per_step"), per_step, 1e-15);
    EXPECT_NEAR(seconds.number(r, "seconds_per_second"), steps * per_step, 1e-9);
    EXPECT_EQ(seconds.text(r, "status"), "ok");
  };
  expect(0, "safe", 1 / dt, 4e-3);
  expect(1, "safe", 1 / dt, 1e-3);
  EXPECT_EQ(seconds.text(2, "status"), "skipped: too large");
  expect(3, "1/1200 s", 1200, 3e-3);
  expect(4, "1/60 s", 60, 30e-3);  // ten iterations a step
  EXPECT_EQ(seconds.number(4, "iterations"), 10);
  EXPECT_NEAR(seconds.number(4, "q1"), 60 * 27e-3, 1e-12);
  EXPECT_NEAR(seconds.number(4, "q3"), 60 * 36e-3, 1e-12);
  EXPECT_EQ(seconds.text(5, "status"), "step not known");
  expect(6, "1/60 s", 60, 6);
  EXPECT_EQ(seconds.text(6, "precision"), "single");
}

TEST(TimingSeconds, HaveNoRowOfWhatIsNotInstalled) {
  std::vector<NamedTable> tables = rows_of_seven();
  Table none({{"program"}, {"cells"}, {"seconds_per_step"}, {"our_precision"}, {"status"}});
  none.add({"Bullet", 0, no_value, "", "not installed"});
  tables.back().table = none;
  EXPECT_EQ(timing_seconds(tables).where("method", "Bullet").size(), 0U);
  tables.back().table = Table::read(none.csv(), "timing_peers.csv");
  EXPECT_EQ(timing_seconds(tables).where("method", "Bullet").size(), 0U);
}

TEST(TimingSeconds, AreChartedWithTheirSteps) {
  const Chart chart = seconds_chart(timing_seconds(rows_of_seven()));
  std::vector<std::string> labels;
  for (const ChartSeries& series : chart.series) {
    labels.push_back(series.label);
    EXPECT_EQ(series.points.size(), 1U) << series.label;
  }
  EXPECT_EQ(labels,
            (std::vector<std::string>{"plain loop in double: safe step", "sweep in double: safe step",
                                      "XPBD in double: 1/1200 s, 1 it.", "VBD in double: 1/60 s, 10 it.",
                                      "Bullet's links in single: 1/60 s, 1 it."}));
  EXPECT_NEAR(chart.series[2].points[0].y, 3.6, 1e-12);
  ASSERT_EQ(chart.lines.size(), 1U);
  EXPECT_EQ(chart.lines[0].at, 1);  // real time
  EXPECT_FALSE(has_points(seconds_chart(timing_seconds({{"timing", synthetic({}, 1, 3)}}))));
}

/// What both precisions have is shown once: the thesis's loops in double, what games use in single.
TEST(TimingSeconds, AreChartedInOnePrecision) {
  std::vector<NamedTable> tables = rows_of_seven();
  Table& loops = tables[0].table;
  for (const char* method : {"plain_loop", "structured_sweep"})
    loops.add({method, "semi_implicit_euler", "single", 1, 7, 5068, 1e-3, 1e-3, 1e-3, "ok", 1.0});
  tables[2].table.add({"xpbd", "single", 1, 1, 7, 1e-3, 1e-3, 1e-3, 1.0, 1.0, 1.0, "ok"});
  std::vector<std::string> labels;
  for (const ChartSeries& series : seconds_chart(timing_seconds(tables)).series)
    labels.push_back(series.label);
  EXPECT_EQ(labels, (std::vector<std::string>{"plain loop in double: safe step", "sweep in double: safe step",
                                              "sweep in single: safe step", "VBD in double: 1/60 s, 10 it.",
                                              "XPBD in single: 1/1200 s, 1 it.",
                                              "Bullet's links in single: 1/60 s, 1 it."}));
}

TEST(TimingSeconds, TextWithholdsTimesOfWideQuartiles) {
  const std::string sound = seconds_text(timing_seconds(rows_of_seven()));
  EXPECT_NE(sound.find("n = 7, VBD in double: 1/60 s, 10 it.: 60 steps, 1.8 s\n"), std::string::npos)
      << sound;
  const std::string wide = seconds_text(timing_seconds(rows_of_seven(3)));
  EXPECT_NE(wide.find("10 it.: 60 steps, time withheld: quartiles a factor of 3.3 apart\n"),
            std::string::npos)
      << wide;
}

/// Results from before there was a table of them are drawn all the same.
TEST(TimingSeconds, AreDrawnWithAndWithoutTheirTable) {
  std::vector<NamedTable> tables = rows_of_seven();
  Progress silent;
  tables.push_back({"timing_features", measure_features({.cells = {}}, silent).features});
  const auto before = scripts(draw_timing(tables));
  tables.push_back({"timing_seconds", timing_seconds(tables)});
  EXPECT_EQ(scripts(draw_timing(tables)), before);
  expect_same_drawings(find_experiment("timing"), tables);
  for (const char* chart : {"timing_seconds", "timing_rates"})
    EXPECT_EQ(
        std::count_if(before.begin(), before.end(), [&](const auto& drawn) { return drawn.first == chart; }),
        1)
        << chart;
}

TEST(TimingRates, StandBesidePublishedOnes) {
  const std::vector<NamedTable> tables = rows_of_seven();
  const Chart chart = rates_chart(find_table(tables, "timing"));
  const auto& published = reference::published_rates();
  ASSERT_EQ(chart.series.size(), 3 + published.size());
  EXPECT_EQ(chart.series[1].label, "sweep in double, 1 thread");
  ASSERT_EQ(chart.series[1].points.size(), 1U);
  EXPECT_NEAR(chart.series[1].points[0].y, 5068e3, 1e-6);
  EXPECT_NEAR(chart.series[1].points[0].low, 5068e3 / 1.2, 1e-6);
  EXPECT_NEAR(chart.series[1].points[0].high, 5068e3 / 0.9, 1e-6);
  EXPECT_TRUE(chart.series[2].points.empty());  // Algorithm 1 was skipped
  for (std::size_t i = 0; i < published.size(); ++i) {
    const ChartSeries& line = chart.series[3 + i];
    EXPECT_TRUE(line.label.starts_with(published[i].program)) << line.label;
    EXPECT_NE(line.label.find("published"), std::string::npos) << line.label;
    EXPECT_FALSE(line.marked);  // nothing was measured
    ASSERT_EQ(line.points.size(), 2U);
    EXPECT_EQ(line.points[0].x, chart.x.low);
    EXPECT_EQ(line.points[1].x, chart.x.high);
    for (const ChartPoint& p : line.points) EXPECT_EQ(p.y, published[i].rate);
  }
  EXPECT_NE(chart.legend_title.find("not measured here"), std::string::npos);
}

TEST(PublishedRates, AreQuotedWithTheirSources) {
  const auto& rates = reference::published_rates();
  ASSERT_EQ(rates.size(), 2U);
  EXPECT_EQ(rates[0].program, "Titan");
  EXPECT_EQ(rates[0].year, 2020);
  EXPECT_EQ(rates[0].rate, 3e8);
  EXPECT_NE(rates[0].quoted.find("300 million"), std::string::npos);
  EXPECT_EQ(rates[1].program, "Cronos");
  EXPECT_EQ(rates[1].year, 2022);
  EXPECT_EQ(rates[1].rate, 1e9);
  EXPECT_NE(rates[1].quoted.find("1 billion"), std::string::npos);
  for (const reference::PublishedRate& rate : rates) {
    EXPECT_NE(rate.hardware.find("GPU"), std::string::npos);
    EXPECT_NE(rate.source.find("arXiv"), std::string::npos);
    EXPECT_FALSE(rate.counted.empty());
  }
}

}  // namespace
}  // namespace mss::studies::timing
