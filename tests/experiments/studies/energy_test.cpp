// `mss energy`: symplectic methods are bounded, energy-conserving ones exact, the others neither, failures
// are rows.
#include "experiments/studies/energy/energy.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "experiments/studies/energy/spin.hpp"
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
/// Without what repeats another method of the chart; what stands for itself stays, whatever it is a variant
/// of.
TEST(Energy, ChartsHaveEachMethodOnce) {
  EXPECT_EQ(without_variants(
                {"semi_implicit_euler", "verlet", "vbd:5", "vbd", "backward_euler/lbfgs:5", "xpbd:20"}),
            (std::vector<std::string>{"semi_implicit_euler", "vbd", "backward_euler/lbfgs:5", "xpbd:20"}));
  EXPECT_EQ(without_variants({"verlet", "cvode_bdf_klu"}),
            (std::vector<std::string>{"verlet", "cvode_bdf_klu"}));
}

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

Table spins(const SpinConfig& config) {
  Progress progress;
  Journal journal;
  const SpinTables tables = measure_spin(config, 1, journal, progress);
  EXPECT_EQ(tables.status, Status::ok);
  return spin_summary(tables.rows);
}

double left_of_spin(const Table& left, const char* method, const char* column) {
  return left.where("integrator", method).number(0, column);
}

/// By methods whose facts say what they keep: to rounding, or what their solver leaves.
TEST(EnergySpin, IsKeptByMethodsThatSayTheyDo) {
  SpinConfig config = spin_config({.integrators = {"verlet", "velocity_verlet", "implicit_midpoint",
                                                   "energy_momentum", "backward_euler", "explicit_euler"}});
  config.frames = early_frame;
  config.cells = 2;
  const Table left = spins(config);
  for (const char* method : {"verlet", "velocity_verlet", "implicit_midpoint", "energy_momentum"}) {
    const bool solves = find_integrator(method).implicit;
    EXPECT_NEAR(left_of_spin(left, method, "angular_momentum"), 1, solves ? 1e-4 : 1e-9) << method;
    EXPECT_NEAR(left_of_spin(left, method, "momentum"), 1, 1e-10) << method;
    EXPECT_NEAR(left_of_spin(left, method, "energy"), 1, 0.01) << method;
    EXPECT_EQ(left_of_spin(left, method, "early_angular_momentum"),
              left_of_spin(left, method, "angular_momentum"))
        << method;
  }
  EXPECT_EQ(left_of_spin(left, "energy_momentum", "dt"), 1.0 / 60);
  EXPECT_LT(left_of_spin(left, "verlet", "dt"), 1.0 / 60);
  EXPECT_NEAR(left_of_spin(left, "backward_euler", "momentum"), 1, 1e-10);
  EXPECT_EQ(left.where("integrator", "explicit_euler").text(0, "status"), "no safe step");
}

/// A step of backward Euler turns a rigid body to where x + dt v points: with a the angle of the step before,
/// 2 - exp(-i a) of x; velocities are chords, sin a of them about the centre. The first starts along a
/// tangent.
TEST(EnergySpin, OfARigidBodyByBackwardEulerIsTheClosedForm) {
  SpinConfig config = spin_config({.integrators = {"backward_euler"}});
  config.frames = early_frame;
  config.cells = 1;
  config.young = 1e9;
  constexpr double turned = 10.0 / 60;
  double angle = std::atan(turned);
  for (long i = 1; i < early_frame; ++i) angle = std::atan(std::sin(angle) / (2 - std::cos(angle)));
  const double left = left_of_spin(spins(config), "backward_euler", "angular_momentum");
  EXPECT_NEAR(left / (std::sin(angle) / turned), 1, 1e-3);
  EXPECT_LT(left, 0.5);
}

/// Failures are rows: a run that is too short for two seconds says so, one that diverges has no numbers.
TEST(EnergySpin, FailuresAreRows) {
  SpinConfig config = spin_config({.integrators = {"backward_euler"}});
  config.frames = 3;
  config.cells = 1;
  EXPECT_EQ(spins(config).text(0, "status"), "shorter than two seconds");
  Table rows({{"integrator"}, {"dt"}, {"frame"}, {"energy"}, {"momentum"}, {"angular_momentum"}, {"status"}});
  rows.add({std::string("a"), 0.1, early_frame, 1.0, 1.0, 0.9, std::string("ok")});
  rows.add({std::string("a"), 0.1, 1000, no_value, no_value, no_value, std::string("blows_up")});
  const Table summary = spin_summary(rows);
  ASSERT_EQ(summary.size(), 1U);
  EXPECT_EQ(summary.text(0, "status"), "blows_up");
  EXPECT_EQ(summary.number(0, "early_angular_momentum"), 0.9);
}

TEST(EnergySpin, DrawsFromItsFiles) {
  SpinConfig config = spin_config({.integrators = {"verlet", "vbd:5", "explicit_euler"}});
  config.frames = 200;
  config.cells = 2;
  EnergyConfig energy = energy_config({.integrators = {"verlet"}});
  energy.steps = 300;
  Progress progress;
  Journal journal;
  std::vector<NamedTable> files = energy_files(energy, measure_energy(energy, 1, journal, progress).rows);
  for (NamedTable& table : spin_files(config, measure_spin(config, 1, journal, progress).rows))
    files.push_back(std::move(table));
  expect_same_drawings(find_experiment("energy"), files);
  const Drawings drawn = find_experiment("energy").draw(files);
  ASSERT_EQ(drawn.charts.size(), 2U);
  EXPECT_EQ(drawn.charts[0].chart.y.names, std::vector<std::string>{"verlet"});
  EXPECT_EQ(drawn.charts[1].name, "energy_spin");
  EXPECT_EQ(drawn.charts[1].chart.y.names.size(), 3U);
}

}  // namespace
}  // namespace mss::studies::energy
