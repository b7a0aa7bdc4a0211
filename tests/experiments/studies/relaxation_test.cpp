// `mss validate relaxation`: closed forms, and a bar that is as they say.
#include "experiments/studies/relaxation/relaxation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/read_back.hpp"

namespace mss::studies::relaxation {
namespace {

/// Creep is what the modulus at once and at rest say at its ends, and does not jump where the load stays.
TEST(RelaxationStudy, HasClosedFormsThatAgree) {
  const Relaxation relaxation{.ratio = 0.5, .time = 0.2};
  EXPECT_NEAR(std::abs(complex_modulus(relaxation, 1e6) - 1.5), 0, 1e-6);
  EXPECT_NEAR(std::abs(complex_modulus(relaxation, 1e-6) - 1.0), 0, 1e-6);
  EXPECT_NEAR(complex_modulus(relaxation, 1).imag(), 0.25, 1e-15);
  EXPECT_NEAR(creep(relaxation, 1e-6, 1e-6), 1 / 1.5, 1e-5);
  EXPECT_NEAR(creep(relaxation, 0.05, 10), 1, 1e-12);
  EXPECT_NEAR(creep(relaxation, 0.05, 0.05 - 1e-12), creep(relaxation, 0.05, 0.05), 1e-9);
}

TEST(RelaxationStudy, MeasuresABarBesideThem) {
  RelaxationConfig config = relaxation_config({.quick = true});
  config.frequencies = {1};
  config.steps = {50, 100};
  Progress progress;
  const RelaxationTables tables = measure_relaxation(config, progress);
  ASSERT_EQ(tables.modulus.size(), 2U);
  EXPECT_NEAR(tables.modulus.number(0, "error") / tables.modulus.number(1, "error"), 4, 0.2);
  EXPECT_LT(tables.modulus.number(1, "error"), 1e-3);
  const Table second = tables.creep.where("integrator", "tr_bdf2").where("time", 1),
              first = tables.creep.where("integrator", "backward_euler").where("time", 1);
  ASSERT_EQ(second.size(), 2U);
  EXPECT_NEAR(std::log10(second.number(0, "error") / second.number(1, "error")), 2, 0.2);
  // Nothing swings, so what a step errs is the path in it, whatever the method.
  EXPECT_NEAR(std::log10(first.number(0, "error") / first.number(1, "error")), 2, 0.2);
  for (std::size_t r = 0; r < tables.creep.size(); ++r) EXPECT_EQ(tables.creep.text(r, "status"), "ok");
  expect_same_drawings(find_experiment("relaxation"), relaxation_files(tables));
}

}  // namespace
}  // namespace mss::studies::relaxation
