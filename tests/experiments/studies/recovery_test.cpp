// `mss recovery`: which states trap springs, and that they recover with the fold guard.
#include "experiments/studies/recovery/recovery.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/measures/measures.hpp"
#include "tests/experiments/stop_after.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::recovery {
namespace {

RecoveryConfig small_config(const std::vector<std::string>& models, const std::vector<std::string>& states) {
  RecoveryConfig config = recovery_config({.quick = true});
  const auto named = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  std::erase_if(config.models, [&](const RecoveryModel& m) { return !named(models, m.name); });
  std::erase_if(config.states, [&](const TrappedState& s) { return !named(states, to_string(s)); });
  config.landing_speeds = {};
  return config;
}

Table run(const RecoveryConfig& config, int processes = 2) {
  Journal journal;
  Progress progress;
  const RecoveryTables tables = measure_recovery(config, processes, journal, progress);
  EXPECT_EQ(tables.status, Status::ok);
  return tables.rows;
}

// Spec section 5: with t = 1, nu = .25 a corner pushed through by one cell stays folded.
TEST(Recovery, AFoldedCornerRecoversOnlyWithTheFoldGuard) {
  const std::string plain = "springs, t = 1, nu = 0.25", guarded = plain + ", guarded";
  const Table rows = run(small_config({plain, guarded}, {"corner 1", "mirrored"}));
  ASSERT_EQ(rows.size(), 4U);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    SCOPED_TRACE(rows.text(r, "model") + ", " + rows.text(r, "state"));
    const bool recovers = rows.text(r, "model") == guarded;
    EXPECT_EQ(rows.number(r, "recovered"), recovers ? 1 : 0);
    EXPECT_EQ(rows.text(r, "status"), recovers                              ? "ok"
                                      : rows.text(r, "state") == "mirrored" ? "mirrored"
                                                                            : "trapped");
    if (recovers) {
      EXPECT_LT(rows.number(r, "worst_stretch"), 1e-6);
    }
  }
}

TEST(Recovery, IsTheSameHoweverItIsSplit) {
  const RecoveryConfig config =
      small_config({"springs, t = 0.5, nu = 0.4, guarded"}, {"flat 0.01", "random", "folded layer"});
  EXPECT_EQ(run(config, 1).csv(), run(config, 3).csv());
}

TEST(Recovery, StatesHaveTheGeometryOfTheirNames) {
  const RecoveryConfig config =
      small_config({"thesis"}, {"mirrored", "folded layer", "flat 0.01", "shrunk 0.001"});
  ASSERT_EQ(config.states.size(), 4U);
  const Body body(config.models.at(0).body);
  const auto system = config.models[0].system(body, {});
  for (const TrappedState& trap : config.states) {
    SCOPED_TRACE(to_string(trap));
    State<double> state = system->rest_state();
    const double h = body.config().cell_size;
    for (const std::ptrdiff_t site : system->particles())
      state.x.set(site, h * trap.put(state.x.at(site) / h, Vec3::Zero(), trap.amount));
    const Measures m = measure(*system, state);
    if (trap.name == "mirrored") {
      EXPECT_NEAR(m.min_jacobian, -1, 1e-12);
      EXPECT_NEAR(m.max_stretch, 0, 1e-12);
    } else if (trap.name == "folded layer") {
      EXPECT_NEAR(m.min_jacobian, -1, 1e-12);
    } else {
      EXPECT_NEAR(m.volume_ratio, trap.name == "flat" ? 0.01 : 1e-9, 1e-11);
    }
  }
}

// Fig. 5-4: the thesis's cube lands on its face and stays folded; guarded it lands harder and recovers.
TEST(Recovery, AHardLandingFoldsWithoutTheFoldGuard) {
  RecoveryConfig config = small_config({"thesis", "thesis, guarded"}, {});
  config.landing_speeds = {20, 40, 80};
  Journal journal;
  Progress progress;
  const Table rows = measure_recovery(config, 2, journal, progress).landings;
  ASSERT_EQ(rows.size(), 2 * landings().size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    SCOPED_TRACE(r);
    if (rows.number(r, "guarded") != 0) {
      EXPECT_EQ(rows.number(r, "highest_recovered"), 80);
      EXPECT_TRUE(std::isnan(rows.number(r, "lowest_unrecovered")));
    } else if (rows.text(r, "landing") == "face") {
      EXPECT_EQ(rows.number(r, "highest_recovered"), 20);
      EXPECT_EQ(rows.number(r, "lowest_unrecovered"), 40);
      EXPECT_LT(rows.number(r, "min_jacobian"), 0);
    }
  }
}

TEST(Recovery, TheFoldGuardChangesNothingInOrdinaryMotion) {
  const RecoveryConfig config = recovery_config({.quick = true});
  const Table costs = measure_costs(config, Progress());
  ASSERT_EQ(costs.size(), config.models.size());
  for (std::size_t r = 0; r < costs.size(); ++r) {
    EXPECT_EQ(costs.text(r, "status"), "ok");
    EXPECT_EQ(costs.number(r, "difference"), 0) << costs.text(r, "model");
    EXPECT_GT(costs.number(r, "median"), 0);
  }
}

TEST(Recovery, DrawsTheSameFromItsFiles) {
  RecoveryConfig config =
      small_config({"thesis", "thesis, guarded", "springs, t = 1, nu = 0.25"}, {"corner 1", "mirrored"});
  config.landing_speeds = {20, 40};
  for (const int reports : {4, 1000}) {  // interrupted, and not
    Journal journal;
    StopAfter progress(reports);
    RecoveryTables tables = measure_recovery(config, 2, journal, progress);
    EXPECT_EQ(tables.status, reports == 4 ? Status::interrupted : Status::ok);
    StopAfter at_once(0);
    expect_same_drawings(find_experiment("recovery"),
                         recovery_files(std::move(tables), measure_costs(config, at_once)));
  }
}

// Guarded models are drawn in the row of the same model without guard.
TEST(Recovery, ChartsPairModelsWithAndWithoutTheFoldGuard) {
  RecoveryConfig config = small_config({"thesis", "thesis, guarded"}, {"mirrored"});
  config.landing_speeds = {20, 40};
  Journal journal;
  Progress progress;
  RecoveryTables tables = measure_recovery(config, 2, journal, progress);
  const Drawings drawings =
      draw_recovery(recovery_files(std::move(tables), measure_costs(config, StopAfter(0))));
  ASSERT_EQ(drawings.charts.size(), 2U);
  const Chart& models = drawings.charts[0].chart;
  EXPECT_EQ(models.y.names, std::vector<std::string>{"thesis"});
  ASSERT_EQ(models.series.size(), 2U);
  ASSERT_EQ(models.series[1].points.size(), 1U);
  EXPECT_EQ(models.series[0].points.at(0).x, 0);
  EXPECT_EQ(models.series[1].points[0].x, 1);
  EXPECT_EQ(drawings.charts[1].chart.y.names.size(), landings().size());
}

}  // namespace
}  // namespace mss::studies::recovery
