// `mss energy`: symplectic methods are bounded, the others are not, failures are rows.
#include "experiments/energy.hpp"

#include <gtest/gtest.h>

namespace mss {
namespace {

TEST(Energy, IsBoundedForSymplecticMethodsOnly) {
  EnergyConfig config = energy_config({});
  config.steps = 5000;
  config.integrators = {"explicit_euler", "rk4", "backward_euler", "backward_euler_linear"};
  std::size_t symplectic = 0;
  for (const IntegratorInfo& info : integrators())
    if (info.symplectic) {
      config.integrators.push_back(info.name);
      ++symplectic;
    }
  EXPECT_GE(symplectic, 4U);
  Progress progress;
  const EnergyTables tables = measure_energy(config, progress);
  ASSERT_EQ(tables.status, Status::ok);
  const Table summary = energy_summary(tables.rows, config.steps);
  ASSERT_EQ(summary.size(), config.integrators.size());
  for (std::size_t r = 0; r < summary.size(); ++r) {
    const std::string& name = summary.text(r, "integrator");
    if (find_integrator(name).symplectic)
      EXPECT_EQ(summary.text(r, "energy"), "bounded") << name;
    else
      EXPECT_NE(summary.text(r, "energy"), "bounded") << name;
  }
  EXPECT_EQ(summary.text(0, "status"), "non_finite");
}

TEST(Energy, KeepsFinishedRowsWhenStopped) {
  struct Stopper final : Progress {
    bool stopped() const override { return ++asked > 12; }
    mutable int asked = 0;
  } progress;
  EnergyConfig config = energy_config({.quick = true, .integrators = {"verlet", "rk4"}});
  const EnergyTables tables = measure_energy(config, progress);
  EXPECT_EQ(tables.status, Status::interrupted);
  EXPECT_EQ(tables.rows.size(), 12U);
  EXPECT_EQ(energy_summary(tables.rows, config.steps).size(), 0U);
}

}  // namespace
}  // namespace mss
