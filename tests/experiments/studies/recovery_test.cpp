// `mss recovery`: what traps springs, and that the guard undoes it.
#include "experiments/studies/recovery/recovery.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/measures.hpp"
#include "experiments/simulation/model.hpp"

namespace mss::studies::recovery {
namespace {

RecoveryConfig small_zoo(const std::vector<std::string>& models, const std::vector<std::string>& states) {
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
TEST(Recovery, AFoldedCornerStaysUnlessItIsGuarded) {
  const std::string plain = "springs, t = 1, nu = 0.25", guarded = plain + ", guarded";
  const Table rows = run(small_zoo({plain, guarded}, {"corner 1", "mirrored"}));
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
      small_zoo({"springs, t = 0.5, nu = 0.4, guarded"}, {"flat 0.01", "random", "folded layer"});
  EXPECT_EQ(run(config, 1).csv(), run(config, 3).csv());
}

TEST(Recovery, StatesAreWhatTheyAreCalled) {
  const RecoveryConfig config =
      small_zoo({"thesis"}, {"mirrored", "folded layer", "flat 0.01", "crushed 0.001"});
  ASSERT_EQ(config.states.size(), 4U);
  const Body body(config.models.at(0).body);
  const auto system = make_system<double>(config.models[0].model, body, {}, 1);
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
TEST(Recovery, AHardLandingFoldsUnlessItIsGuarded) {
  RecoveryConfig config = small_zoo({"thesis", "thesis, guarded"}, {});
  config.landing_speeds = {20, 40, 80};
  Journal journal;
  Progress progress;
  const Table rows = measure_recovery(config, 2, journal, progress).landings;
  ASSERT_EQ(rows.size(), 2 * landings().size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    SCOPED_TRACE(r);
    if (rows.number(r, "guarded") != 0) {
      EXPECT_EQ(rows.number(r, "recovers_to"), 80);
      EXPECT_TRUE(std::isnan(rows.number(r, "folds_at")));
    } else if (rows.text(r, "landing") == "face") {
      EXPECT_EQ(rows.number(r, "recovers_to"), 20);
      EXPECT_EQ(rows.number(r, "folds_at"), 40);
      EXPECT_LT(rows.number(r, "min_jacobian"), 0);
    }
  }
}

TEST(Recovery, TheGuardMovesNothingInOrdinaryScenes) {
  const RecoveryConfig config = recovery_config({.quick = true});
  const Table costs = measure_costs(config, Progress());
  ASSERT_EQ(costs.size(), config.models.size());
  for (std::size_t r = 0; r < costs.size(); ++r) {
    EXPECT_EQ(costs.text(r, "status"), "ok");
    EXPECT_EQ(costs.number(r, "difference"), 0) << costs.text(r, "model");
    EXPECT_GT(costs.number(r, "median"), 0);
  }
}

}  // namespace
}  // namespace mss::studies::recovery
