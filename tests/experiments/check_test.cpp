// What experiments guard notices a change of the physics: planted ones are named by the right rows.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "experiments/energy.hpp"
#include "experiments/volume.hpp"

namespace mss {
namespace {

const Guard& guard_of(const std::string& name) {
  for (const ExperimentInfo& info : experiments())
    if (info.name == name) return info.guard;
  throw std::logic_error("no such experiment");
}

TEST(Guards, OfEveryExperimentNameTheirRows) {
  for (const ExperimentInfo& info : experiments()) {
    EXPECT_FALSE(info.guard.keys.empty()) << info.name;
    EXPECT_TRUE(info.guard.table) << info.name;
  }
}

Table volume_rows(double share_of_volume_stiffness) {
  VolumeConfig config = volume_config({.quick = true});
  config.cells = {2};
  config.strains = {0.1};
  config.stiffness = {1e3 * share_of_volume_stiffness};
  config.models.resize(4);
  Progress progress;
  return measure_volume(config, progress).rows;
}

TEST(Guards, SeeAVolumeForceOfHalfTheStrength) {
  const std::string before = volume_rows(1).csv();
  EXPECT_TRUE(compare(before, volume_rows(1).csv(), guard_of("volume")).empty());
  // k_vol is part of a row's name: rename it, as a mistake inside the force would leave it.
  std::string halved = volume_rows(0.5).csv();
  for (std::size_t at = 0; (at = halved.find("k_vol = 500", at)) != std::string::npos;)
    halved.replace(at, 11, "k_vol = 1000");
  for (std::size_t at = 0; (at = halved.find(",500,", at)) != std::string::npos;)
    halved.replace(at, 5, ",1000,");
  const auto moved = compare(before, halved, guard_of("volume"));
  ASSERT_FALSE(moved.empty());
  for (const Deviation& d : moved) EXPECT_NE(d.row.find("study = k_vol"), std::string::npos) << to_string(d);
}

TEST(Guards, SeeAnotherStep) {
  const auto rows = [](double share) {
    EnergyConfig config = energy_config({});
    config.steps = 40;
    config.integrators = {"velocity_verlet", "rk4"};
    config.step_share = share;
    Progress progress;
    return measure_energy(config, progress).rows.csv();
  };
  const auto moved = compare(rows(0.25), rows(0.26), guard_of("energy"));
  ASSERT_FALSE(moved.empty());
  EXPECT_EQ(moved.front().row, "integrator = velocity_verlet, step = 1");
  EXPECT_TRUE(
      std::any_of(moved.begin(), moved.end(), [](const Deviation& d) { return d.column == "energy_error"; }));
}

}  // namespace
}  // namespace mss
