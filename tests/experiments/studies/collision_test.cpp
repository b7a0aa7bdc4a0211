// `mss validate contact`, bodies that hit each other: bars against the exact solution, blocks against what
// they must keep.
#include "experiments/studies/contact/collision.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "experiments/studies/contact/contact.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::contact {
namespace {

Table bars(const BarRun& run) {
  Table rows = empty_bars();
  add_bar_run(run, rows);
  return rows;
}

Table balance(const BalanceRun& run) {
  Table rows = empty_balance();
  add_balance_run(run, rows);
  return rows;
}

TEST(Collision, BarsTouchAsLongAsAWaveRuns) {
  for (const double stiffness : {1.0, 4.0}) {
    const Table row = bars({.cells = 20, .stiffness = stiffness});
    EXPECT_EQ(row.text(0, "status"), "ok") << row.csv();
    EXPECT_NEAR(row.number(0, "duration_over_exact"), 1, 0.015);
    EXPECT_NEAR(row.number(0, "touching_over_exact"), 1.013, 0.01);
    EXPECT_GT(row.number(0, "restitution"), 0.97);
    EXPECT_LT(row.number(0, "restitution"), 1);
  }
  const Table finer = bars({.cells = 40});
  EXPECT_EQ(finer.text(0, "status"), "ok") << finer.csv();
  EXPECT_LT(finer.number(0, "vibration"), 0.015);
}

TEST(Collision, SlowBarsTouchLonger) {
  const Table row = bars({.cells = 10, .speed = 0.001});
  EXPECT_EQ(row.text(0, "status"), "not_claimed");
  EXPECT_GT(row.number(0, "duration_over_exact"), 1.05);
}

TEST(Collision, BlocksKeepMomentumAndEnergy) {
  for (const auto& [meeting, friction] :
       {std::pair{Meeting::faces, 0.0}, std::pair{Meeting::edge, 0.4}, std::pair{Meeting::corner, 0.0}}) {
    const Table row = balance({meeting, friction, "pefrl"});
    EXPECT_EQ(row.text(0, "status"), "ok") << row.csv();
    EXPECT_GT(row.number(0, "steps_touching"), 20);
    EXPECT_LT(row.number(0, "angular_momentum_change"), 1e-14);
    EXPECT_NEAR(row.number(0, "energy_end"), friction > 0 ? -0.024 : 0, 1e-3);
  }
}

TEST(Collision, TheErrorOfVelocityVerletIsSeen) {
  const Table row = balance({.meeting = Meeting::faces});
  EXPECT_EQ(row.text(0, "status"), "off") << row.csv();
  const Table half = balance({.meeting = Meeting::faces, .share = 0.25});
  EXPECT_EQ(half.text(0, "status"), "ok");
  EXPECT_NEAR(half.number(0, "energy_lowest") / row.number(0, "energy_lowest"), 0.25, 0.1);
}

TEST(Collision, EveryRunIsARowAndIsDrawn) {
  ContactConfig config;
  config.laws.clear();
  config.collision = collision_config(true);
  Journal journal;
  Progress progress;
  const ContactTables tables = measure_contact(config, 2, journal, progress);
  EXPECT_EQ(tables.bars.size(), config.collision.bars.size());
  EXPECT_EQ(tables.balance.size(), config.collision.blocks.size());
  const std::vector<NamedTable> files = contact_files(tables);
  expect_same_drawings(find_experiment("contact"), files);
  const std::vector<NamedChart> charts = draw_contact(files).charts;
  ASSERT_EQ(charts.size(), 1U);
  EXPECT_EQ(charts[0].chart.series.size(), 4U);
}

}  // namespace
}  // namespace mss::studies::contact
