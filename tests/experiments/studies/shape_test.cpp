// `mss shape`: cells that a surface fills in part shorten the step by no more than they may, have no
// vibration of their own below the body's, and keep its volume.
#include "experiments/studies/shape/shape.hpp"

#include <gtest/gtest.h>

namespace mss::studies::shape {
namespace {

TEST(Shape, CellsAtTheSurfaceAddNoSlowModesAndKeepTheStepAndTheVolume) {
  ShapeConfig config = shape_config({.quick = true, .cells = {5}});
  config.fillings = {{.name = "local"}};
  config.reference_cells = {2, 4, 8};
  config.offsets = 1;
  config.step_offsets = 6;
  config.step_poissons = {0, 0.3};
  Progress progress;
  Journal journal;
  const ShapeTables tables = measure_shape(config, 1, journal, progress);
  ASSERT_EQ(tables.status, Status::ok);
  ASSERT_EQ(tables.steps.size(), 2U * (3 * 6 + 1));  // the aligned bar has one place
  for (std::size_t r = 0; r < tables.steps.size(); ++r) {
    const std::string at =
        tables.steps.text(r, "body") + ", place " + std::to_string(int(tables.steps.number(r, "place")));
    EXPECT_EQ(tables.steps.text(r, "status"), "ok") << at;
    EXPECT_GE(tables.steps.number(r, "step_over_full"), 0.7) << at;
    EXPECT_NEAR(tables.steps.number(r, "slowest_over_expected"), 0.95, 0.1) << at;
  }
  for (std::size_t r = 0; r < tables.rows.size(); ++r)
    EXPECT_NEAR(tables.rows.number(r, "volume_error"), 0, 1e-3) << tables.rows.text(r, "body");
}

}  // namespace
}  // namespace mss::studies::shape
