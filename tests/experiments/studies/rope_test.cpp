// `mss validate rope`: ropes and sheets are as the closed forms of their lattices say, and tend to strings,
// membranes and the catenary.
#include "experiments/studies/rope/rope.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "reference/closed_forms.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::rope {
namespace {

TEST(RopeStudy, HasClosedFormsThatAgree) {
  const reference::Stretched body{.length = 2, .tension = 5, .mass = 0.3};
  EXPECT_NEAR(reference::beaded_string_frequency(body, 100000, 3), reference::string_frequency(body, 3),
              1e-6);
  EXPECT_NEAR(reference::net_frequency(body, 100000, 1, 2), reference::membrane_frequency(body, 1, 2), 1e-6);
  EXPECT_NEAR(reference::beaded_string_frequency(body, 2, 1),  // one bead between two springs
              std::sqrt(2 * 5.0 / 1 / 0.3) / (2 * M_PI), 1e-12);
  const reference::Catenary hanging = reference::catenary(2, 1.4, 0);
  const double a = 2 * hanging.pull;  // y = a cosh(x / a)
  EXPECT_NEAR(2 * a * std::sinh(0.7 / a), 2, 1e-12);
  EXPECT_NEAR(hanging.sag, a * std::cosh(0.7 / a) - a, 1e-12);
  // Doubled, each half hangs by itself and sinks by its own weight over 2 E A more.
  EXPECT_NEAR(reference::catenary(2, 1e-9, 0.1).sag, 1 + 0.1 * 2 / 8, 1e-6);
}

TEST(RopeStudy, MeasuresRopesAndSheetsBesideThem) {
  Progress progress;
  const RopeTables tables = measure_ropes(rope_config({.quick = true}), progress);
  ASSERT_GT(tables.waves.size(), 20U);
  for (std::size_t r = 0; r < tables.waves.size(); ++r) {
    EXPECT_EQ(tables.waves.text(r, "status"), "ok");
    EXPECT_LT(tables.waves.number(r, "error_lattice"), 1e-9);
  }
  const auto order_at = [](const Table& rows, const char* column, std::size_t row) {
    return std::log2(rows.number(row - 1, column) / rows.number(row, column));
  };
  const auto order = [&](const Table& rows, const char* column) {
    return order_at(rows, column, rows.size() - 1);
  };
  const Table across = tables.waves.where("body", "rope").where("motion", "across").where("mode", "1"),
              sheet = tables.waves.where("body", "sheet").where("mode", "1,1");
  EXPECT_NEAR(order(across, "error_continuum"), 2, 0.05);
  EXPECT_NEAR(order(sheet, "error_continuum"), 2, 0.1);
  ASSERT_EQ(tables.pulses.size(), 3U) << "of 16, 32 and 64 links";
  for (std::size_t r = 1; r < tables.pulses.size(); ++r)
    EXPECT_NEAR(order_at(tables.pulses, "error", r), 2, 0.15) << tables.pulses.number(r, "links");
  for (std::size_t r = 0; r < tables.catenaries.size(); ++r)
    EXPECT_EQ(tables.catenaries.text(r, "status"), "ok");
  const std::size_t last = tables.catenaries.size() - 1;
  EXPECT_EQ(tables.catenaries.number(last, "links"), 64);
  for (const char* error : {"error_sag", "error_pull", "error_rise"})
    EXPECT_LT(tables.catenaries.number(last, error), 1e-3) << error;
  expect_same_drawings(find_experiment("rope"), rope_files(tables));
}

}  // namespace
}  // namespace mss::studies::rope
