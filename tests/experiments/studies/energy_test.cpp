// `mss energy`: symplectic methods are bounded, energy-conserving ones exact, the others neither, failures
// are rows.
#include "experiments/studies/energy/energy.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/experiments/stop_after.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::energy {
namespace {

TEST(Energy, IsKeptByMethodsThatSayTheyDo) {
  EnergyConfig config = energy_config({});
  config.steps = 5000;
  config.stretch = 1.02;  // so little that vibrations have not begun to mix when the count ends
  config.integrators = {"explicit_euler", "rk4", "backward_euler", "backward_euler_linear"};
  std::size_t kept = 0;
  for (const IntegratorInfo& info : integrators())
    if (info.symplectic || info.energy_exact) {
      config.integrators.push_back(info.name);
      ++kept;
    }
  EXPECT_GE(kept, 7U);
  Progress progress;
  Journal journal;
  const EnergyTables tables = measure_energy(config, 1, journal, progress);
  ASSERT_EQ(tables.status, Status::ok);
  const Table summary = energy_summary(tables.rows, config.steps);
  ASSERT_EQ(summary.size(), config.integrators.size());
  for (std::size_t r = 0; r < summary.size(); ++r) {
    const std::string& name = summary.text(r, "integrator");
    if (find_integrator(name).energy_exact)
      EXPECT_EQ(summary.text(r, "energy"), "exact") << name;
    else if (find_integrator(name).symplectic)
      EXPECT_EQ(summary.text(r, "energy"), "bounded") << name;
    else
      EXPECT_NE(summary.text(r, "energy"), "bounded") << name;
  }
  EXPECT_EQ(summary.text(0, "status"), "non_finite");
}

// What a worker finishes before it is ended is kept too.
TEST(Energy, KeepsFinishedRowsWhenStopped) {
  StopAfter progress(1);
  EnergyConfig config = energy_config({.integrators = {"verlet", "backward_euler", "implicit_midpoint"}});
  config.steps = 1000;
  Journal journal;
  const EnergyTables tables = measure_energy(config, 1, journal, progress);
  EXPECT_EQ(tables.status, Status::interrupted);
  const std::vector<std::string> kept = tables.rows.distinct("integrator");
  ASSERT_GE(kept.size(), 1U);
  EXPECT_LT(kept.size(), config.integrators.size());
  EXPECT_EQ(kept[0], "verlet");
  EXPECT_EQ(energy_summary(tables.rows, config.steps).size(), kept.size());
}

TEST(Energy, DrawsFromItsFiles) {
  EnergyConfig config =
      energy_config({.integrators = {"explicit_euler", "verlet", "rk4"}, .model = "corotational"});
  config.steps = 300;
  Progress progress;
  Journal journal;
  const EnergyTables tables = measure_energy(config, 1, journal, progress);
  expect_same_drawings(find_experiment("energy"), energy_files(config, tables.rows));
}

/// What a step does to the energy of x'' = -w^2 x: explicit Euler multiplies it by 1 + z^2 with z = w dt,
/// backward Euler divides by that, the midpoint rule keeps it; velocity Verlet's is 1 - z^2 / 4 sin^2(n
/// theta) after n steps from the largest stretch, with cos theta = 1 - z^2 / 2.
TEST(Energy, OfOneModeIsTheClosedForm) {
  EnergyConfig config = one_mode_config();
  config.integrators = {"explicit_euler", "backward_euler", "implicit_midpoint", "velocity_verlet"};
  Progress progress;
  Journal journal;
  const Table rows = measure_energy(config, 1, journal, progress).rows;
  const auto error = [&](const char* name, double step) {
    return rows.where("integrator", name).where("step", step).number(0, "energy_error");
  };
  const double z2 = mode_step * mode_step, theta = std::acos(1 - z2 / 2);
  EXPECT_NEAR(error("explicit_euler", 100) / (std::pow(1 + z2, 100) - 1), 1, 1e-4);
  EXPECT_NEAR(error("backward_euler", 100) / (1 - std::pow(1 + z2, -100)), 1, 1e-4);
  EXPECT_NEAR(error("implicit_midpoint", 100), 0, 1e-5);
  for (const int step : {1, 2, 3, 4})
    EXPECT_NEAR(error("velocity_verlet", step), z2 / 4 * std::pow(std::sin(step * theta), 2), 1e-4 * z2);
}

/// Rows of one method whose error grows as a power of time.
Table planted(double power) {
  Table rows({{"integrator"}, {"step"}, {"energy_error"}, {"status"}});
  for (const int step : {1, 10, 100, 1000})
    rows.add({std::string("a"), step, 1e-4 * std::pow(step, power), std::string("ok")});
  return rows;
}

TEST(EnergySummary, DistinguishesDriftsFromPlateaus) {
  EXPECT_EQ(energy_summary(planted(0), 1000).text(0, "energy"), "bounded");
  EXPECT_EQ(energy_summary(planted(0.5), 1000).text(0, "energy"), "drifts");
  EXPECT_EQ(energy_summary(planted(1), 1000).text(0, "energy"), "drifts");
  EXPECT_EQ(energy_summary(planted(1.5), 1000).text(0, "energy"), "lost");
}

}  // namespace
}  // namespace mss::studies::energy
