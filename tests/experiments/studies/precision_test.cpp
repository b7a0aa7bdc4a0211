// `mss precision`: errors fall with the order of the method, failed runs are rows, summaries name the
// cheapest method, and charts need nothing but the tables.
#include "experiments/studies/precision/precision.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::precision {
namespace {

/// The quick configuration's first scene, with a few methods.
PrecisionConfig small_config() {
  PrecisionConfig config = precision_config({.quick = true});
  config.scenes.resize(1);
  config.integrators = {"semi_implicit_euler", "velocity_verlet", "rk4", "backward_euler", "cvode_bdf"};
  config.seconds_per_run = config.seconds_to_agree =
      3600;  // never reached: the number of runs is the limit, however busy the machine
  config.finest_halving = 7;
  return config;
}

struct Stopper final : Progress {
  explicit Stopper(int reports) : left(reports) {}
  void report(double, std::string_view) override { --left; }
  bool stopped() const override { return left <= 0; }
  int left;
};

std::vector<double> errors_of(const Table& rows, const std::string& integrator) {
  std::vector<double> errors;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "integrator") == integrator && rows.text(r, "status") == "ok")
      errors.push_back(rows.number(r, "error"));
  return errors;
}

TEST(Precision, ErrorsFallAsTheOrdersSay) {
  Progress progress;
  const PrecisionTables tables = measure_precision(small_config(), progress);
  ASSERT_EQ(tables.status, Status::ok);
  ASSERT_EQ(tables.references.size(), 1U);
  EXPECT_LT(tables.references.number(0, "uncertainty"), 1e-9);
  EXPECT_GT(tables.references.number(0, "uncertainty"), 0);  // two methods, not one
  const auto last_order = [&](const std::string& integrator) {
    const auto errors = errors_of(tables.rows, integrator);
    EXPECT_GE(errors.size(), 3U) << integrator;
    return std::log2(errors[errors.size() - 2] / errors.back());
  };
  EXPECT_NEAR(last_order("semi_implicit_euler"), 1, 0.1);
  EXPECT_NEAR(last_order("velocity_verlet"), 2, 0.1);
  EXPECT_NEAR(last_order("rk4"), 4, 0.2);
  EXPECT_NEAR(last_order("backward_euler"), 1, 0.1);
  EXPECT_LT(errors_of(tables.rows, "cvode_bdf").back(), 1e-7);
  ASSERT_EQ(tables.agreement.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_EQ(tables.agreement.text(i, "status").substr(0, 2), "ok")
        << tables.agreement.text(i, "integrator");
}

TEST(Precision, FailuresAreRowsWithAReason) {
  PrecisionConfig config = small_config();
  config.scenes[0].body.springs =
      calibrate({.young = 1e8, .poisson = 0.3}, config.scenes[0].body.cell_size, 0.5);
  config.integrators = {"velocity_verlet"};
  Progress progress;
  const PrecisionTables tables = measure_precision(config, progress);
  ASSERT_GT(tables.rows.size(), 3U);
  EXPECT_EQ(tables.rows.text(0, "status"), "non_finite");
  EXPECT_TRUE(std::isnan(tables.rows.number(0, "error")));
  const Chart chart = precision_chart(tables.rows, tables.references, config.scenes[0].name);
  const ReferenceLine& line = chart.lines.back();
  EXPECT_EQ(line.label, "failed: non_finite");
  const ChartSeries &method = chart.series.front(), &failed = chart.series.back();
  EXPECT_EQ(method.label, "velocity_verlet");
  EXPECT_EQ(failed.style, 0);  // the marker of the method
  ASSERT_FALSE(failed.points.empty());
  for (const ChartPoint& point : failed.points) EXPECT_EQ(point.y, line.at);
  for (const ChartPoint& point : method.points) EXPECT_LT(point.y, line.at);
}

TEST(Precision, DrawsFromItsFiles) {
  PrecisionConfig config = small_config();
  config.model = "corotational";
  config.integrators = {"velocity_verlet", "rk4", "cvode_adams"};
  config.finest_halving = 4;
  Progress progress;
  const std::vector<NamedTable> tables = precision_files(measure_precision(config, progress));
  expect_same_drawings(find_experiment("precision"), tables);
  const Drawings drawings = draw_precision(tables);
  ASSERT_EQ(drawings.charts.size(), 2U);  // the overview, and the scene
  EXPECT_NE(drawings.charts[1].chart.subtitle.find("; model: corotational"), std::string::npos);
}

TEST(Precision, KeepsFinishedRunsWhenStopped) {
  Stopper progress(3);
  const PrecisionTables tables = measure_precision(small_config(), progress);
  EXPECT_EQ(tables.status, Status::interrupted);
  EXPECT_FALSE(errors_of(tables.rows, "semi_implicit_euler").empty());
  EXPECT_TRUE(errors_of(tables.rows, "cvode_bdf").empty());
}

/// Runs as (integrator, error, seconds) on one scene, quartiles 2 percent apart.
Table planted(const std::vector<std::tuple<std::string, double, double>>& runs) {
  Table rows({{"scene"}, {"integrator"}, {"value"}, {"error"}, {"seconds"}, {"q1"}, {"q3"}, {"status"}});
  for (const auto& [integrator, error, seconds] : runs)
    rows.add({std::string("s"), integrator, 1e-3, error, seconds, 0.99 * seconds, 1.01 * seconds,
              std::string("ok")});
  return rows;
}

Table no_references() { return Table({{"scene"}, {"description"}, {"uncertainty"}, {"status"}}); }

TEST(Precision, TimesHaveQuartilesAndAreCountedInExplicitSteps) {
  PrecisionConfig config = small_config();
  config.integrators = {"velocity_verlet", "backward_euler_linear"};
  config.finest_halving = 4;
  config.repetitions = 3;
  config.seconds_per_row = config.seconds_per_run = 3600;  // a busy machine leaves no repetition out
  Progress progress;
  const PrecisionTables tables = measure_precision(config, progress);
  const double step = tables.references.number(0, "explicit_step_seconds");
  EXPECT_GT(step, 0);
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    const bool ok = tables.rows.text(r, "status") == "ok";
    EXPECT_EQ(tables.rows.number(r, "repeats"), ok ? 3 : 1);
    EXPECT_LE(tables.rows.number(r, "q1"), tables.rows.number(r, "seconds"));
    EXPECT_GE(tables.rows.number(r, "q3"), tables.rows.number(r, "seconds"));
    EXPECT_DOUBLE_EQ(tables.rows.number(r, "explicit_steps"), tables.rows.number(r, "seconds") / step);
  }
}

TEST(PrecisionSummary, OverlappingQuartilesAreATie) {
  const Table summary =
      precision_summary(planted({{"a", 5e-3, 1.0}, {"b", 1e-2, 1.015}, {"b", 1e-7, 8.0}}), no_references());
  EXPECT_EQ(summary.number(0, "tie"), 1);
  EXPECT_EQ(summary.text(0, "comparison"), "tie with b");
  const Table clear = precision_summary(planted({{"a", 5e-3, 1.0}, {"b", 1e-2, 1.2}}), no_references());
  EXPECT_EQ(clear.number(0, "tie"), 0);
}

TEST(PrecisionChart, ComparesTheCheapestOfBothKinds) {
  const Chart chart = precision_overview(planted({{"verlet", 1e-2, 2.0},
                                                  {"rk4", 1e-5, 4.0},
                                                  {"backward_euler", 1e-2, 1.0},
                                                  {"tr_bdf2", 1e-2, 0.5},
                                                  {"tr_bdf2", 1e-4, 8.0}}),
                                         no_references());
  ASSERT_EQ(chart.series.size(), 1U);
  for (const ChartPoint& point : chart.series[0].points) {
    EXPECT_GE(point.x, 0.99e-4);
    EXPECT_DOUBLE_EQ(point.y, point.x > 0.99e-2 ? 0.25 : 2);
  }
  EXPECT_EQ(chart.series[0].points.size(), 7U);  // from 1e-4 to 1e-1
}

TEST(PrecisionChart, LeavesOutWhatIsNeverWithinTenTimesTheLeastTime) {
  const Chart chart =
      precision_chart(planted({{"verlet", 1e-2, 1.0}, {"rk4", 1e-5, 9.0}, {"backward_euler", 1e-2, 11.0}}),
                      no_references(), "s");
  ASSERT_EQ(chart.series.size(), 2U);
  EXPECT_EQ(chart.series[0].label, "verlet");
  EXPECT_EQ(chart.series[1].label, "rk4");
}

TEST(PrecisionSummary, NamesTheCheapestAndTheNext) {
  const Table summary = precision_summary(
      planted({{"a", 5e-3, 1.0}, {"a", 5e-4, 10.0}, {"b", 1e-2, 3.0}, {"b", 1e-7, 8.0}, {"c", 0.5, 0.1}}),
      no_references());
  ASSERT_EQ(summary.size(), 3U);
  EXPECT_EQ(summary.text(0, "integrator"), "a");  // 1 %
  EXPECT_EQ(summary.text(0, "runner_up"), "b");
  EXPECT_DOUBLE_EQ(summary.number(0, "cost_ratio"), 3);
  EXPECT_EQ(summary.text(1, "integrator"), "b");  // 0.1 %: b's finer run is cheaper than a's
  EXPECT_DOUBLE_EQ(summary.number(1, "cost_ratio"), 1.25);
  EXPECT_EQ(summary.text(2, "integrator"), "b");  // 1e-6: no other method
  EXPECT_EQ(summary.text(2, "status"), "no runner-up");
}

TEST(PrecisionSummary, IsReadWithoutNumbersThatAreNone) {
  const std::string text =
      precision_text(precision_summary(planted({{"a", 5e-3, 1.0}, {"b", 5e-3, 3.0}}), no_references()));
  EXPECT_NE(text.find("1 s  next: b, 3 times the cost\n"), std::string::npos) << text;
  EXPECT_NE(text.find("-  no method reached it in the time allowed\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("nan"), std::string::npos) << text;
}

TEST(PrecisionSummary, TheNextIsOfAnotherFamily) {
  const Table summary =
      precision_summary(planted({{"a:5", 5e-3, 1.0}, {"a", 5e-3, 1.5}, {"b", 1e-2, 3.0}}), no_references());
  EXPECT_EQ(summary.text(0, "integrator"), "a:5");
  EXPECT_EQ(summary.text(0, "runner_up"), "b");
  EXPECT_DOUBLE_EQ(summary.number(0, "cost_ratio"), 3);
}

TEST(PrecisionChart, DrawsAFamilyAsItsEnvelope) {
  const Chart chart = precision_chart(planted({{"vbd", 1e-1, 1.0},
                                               {"vbd", 1e-2, 4.0},
                                               {"vbd:5", 2e-2, 2.0},
                                               {"vbd:5", 1.5e-2, 5.0},
                                               {"b", 1e-2, 3.0}}),
                                      no_references(), "s");
  ASSERT_EQ(chart.series.size(), 2U);
  EXPECT_EQ(chart.series[0].label, "vbd, best of 1, 5");
  ASSERT_EQ(chart.series[0].points.size(), 3U);  // without the one at 5 s
  EXPECT_EQ(chart.series[0].points[1].y, 2e-2);
  EXPECT_EQ(chart.series[1].label, "b");
}

TEST(PrecisionSummary, IsSilentWhereTheReferenceIsNotCertain) {
  Table references = no_references();
  references.add({std::string("s"), std::string(), 2e-4, std::string("ok")});
  const Table runs = planted({{"verlet", 1e-3, 1.0}, {"backward_euler", 1e-3, 3.0}});
  const Table summary = precision_summary(runs, references);
  EXPECT_EQ(summary.text(0, "integrator"), "verlet");  // 1 %
  for (const std::size_t r : {1, 2}) {
    EXPECT_EQ(summary.text(r, "integrator"), "none");
    EXPECT_EQ(summary.text(r, "status"), "not certain");
  }
  const Chart chart = precision_overview(runs, references);
  ASSERT_FALSE(chart.series.at(0).points.empty());
  for (const ChartPoint& point : chart.series[0].points) EXPECT_GE(point.x, 2e-3);
}

/// A ball that comes to the ground: what has no fixed steps is refused and says so, all others come near a
/// reference whose certainty is measured, and near each other.
TEST(PrecisionBench, FollowsScenesThatComeToAPlane) {
  PrecisionConfig config = small_config();
  config.scenes = {bench_precision(find_bench_case("ball_medium"), 4)};
  config.integrators = {"semi_implicit_euler", "backward_euler/lbfgs:5", "cvode_adams"};
  config.finest_halving = 9;
  Progress progress;
  const PrecisionTables tables = measure_precision(config, progress);
  ASSERT_EQ(tables.references.size(), 1U);
  EXPECT_EQ(tables.references.text(0, "status"), "ok");
  EXPECT_GT(tables.references.number(0, "uncertainty"), 0);
  EXPECT_LT(tables.references.number(0, "uncertainty"), 0.01);
  ASSERT_EQ(tables.agreement.size(), 3U);
  EXPECT_EQ(tables.agreement.text(0, "status"), "the reference is not that certain");
  EXPECT_EQ(tables.agreement.text(2, "status"), "refused");
  EXPECT_LT(errors_of(tables.rows, "semi_implicit_euler").back(), 0.02);
  const auto implicit = errors_of(tables.rows, "backward_euler/lbfgs:5");  // of first order
  ASSERT_GE(implicit.size(), 2U);
  EXPECT_LT(implicit.back(), 0.1);
  EXPECT_LT(implicit.back(), 0.65 * implicit[implicit.size() - 2]);
  EXPECT_TRUE(errors_of(tables.rows, "cvode_adams").empty());
}

/// A free body that turns: smooth, so the references are those of the study's own scenes.
TEST(PrecisionBench, TakesSmoothScenesToTheTightReference) {
  PrecisionConfig config = small_config();
  config.scenes = {bench_precision(find_bench_case("spin_soft"), 2)};
  config.integrators = {"rk4"};
  Progress progress;
  const PrecisionTables tables = measure_precision(config, progress);
  EXPECT_LT(tables.references.number(0, "uncertainty"), 1e-9);
  const auto errors = errors_of(tables.rows, "rk4");
  ASSERT_GE(errors.size(), 3U);
  EXPECT_NEAR(std::log2(errors[errors.size() - 2] / errors.back()), 4, 0.2);
}

/// A scene that does not do what it is meant to has no rows, and says why.
TEST(PrecisionBench, SaysWhatASceneDidNotDo) {
  PrecisionConfig config = small_config();
  config.scenes = {bench_precision(find_bench_case("ball_medium"), 4)};
  config.scenes[0].environment.planes.clear();
  config.integrators = {"semi_implicit_euler"};
  Progress progress;
  const PrecisionTables tables = measure_precision(config, progress);
  EXPECT_EQ(tables.rows.size(), 0U);
  EXPECT_EQ(tables.references.text(0, "status"), "the body is behind a plane");
}

TEST(PrecisionConfigTest, TakesTheScenesThatAreNamed) {
  const PrecisionConfig named =
      precision_config({.quick = true, .scenes = {"slope_stiff_damped", "beam_16_damped"}});
  ASSERT_EQ(named.scenes.size(), 2U);
  EXPECT_EQ(named.scenes[0].name, "slope_stiff_damped");
  EXPECT_EQ(named.scenes[0].body.damping.zeta, 0.5);
  EXPECT_EQ(named.scenes[1].bench, nullptr);
  EXPECT_THROW(precision_config({.scenes = {"ball"}}), InputError);
  EXPECT_THROW(precision_config({.scenes = {"ball_soft", "ball_soft"}}), InputError);
}

TEST(PrecisionSummary, NamesUnreachedErrors) {
  const Table summary = precision_summary(planted({{"a", 5e-3, 1.0}}), no_references());
  EXPECT_EQ(summary.text(2, "status"), "not reached");
  EXPECT_EQ(summary.text(2, "integrator"), "none");
}

TEST(PrecisionConfigTest, TakesEveryMethodOfTheRegistry) {
  const auto taken = precision_config({.quick = true}).integrators;
  for (const IntegratorInfo& info : integrators())
    EXPECT_EQ(std::count(taken.begin(), taken.end(), info.name), info.moves_particles() && info.has_modulus)
        << info.name;
  EXPECT_THROW(precision_config({.integrators = {"static"}}), InputError);
  EXPECT_EQ(precision_config({.integrators = {"rk4"}}).integrators, std::vector<std::string>{"rk4"});
  EXPECT_EQ(precision_config({}).scenes.size(), 11U);
  EXPECT_EQ(small_scenes(precision_config({}).scenes).size(), 3U);
}

}  // namespace
}  // namespace mss::studies::precision
