// The baselines detect changes of the physics: planted ones are reported in the right rows.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <set>

#include "core/forces/cell_geometry.hpp"
#include "core/measures/measures.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/studies/energy/energy.hpp"
#include "experiments/studies/volume/volume.hpp"

namespace mss::cli {
namespace {

const Baseline& baseline_of(const std::string& name) {
  for (const ExperimentInfo& info : experiments())
    if (info.name == name) return info.baseline;
  throw std::logic_error("no such experiment");
}

TEST(Baselines, OfEveryExperimentHaveKeys) {
  for (const ExperimentInfo& info : experiments()) {
    EXPECT_FALSE(info.baseline.keys.empty()) << info.name;
    EXPECT_TRUE(info.baseline.table) << info.name;
  }
}

/// Springs of nu = 0.45, whose volume force matters, and the thesis's, whose volume force does not.
studies::volume::VolumeConfig small_volume_config() {
  studies::volume::VolumeConfig config = studies::volume::volume_config({.quick = true});
  config.cells = {2};
  config.strains = {0.1};
  config.angles = {30};
  config.study_cells = 2;
  std::erase_if(config.models, [](const studies::volume::VolumeModel& m) {
    return m.name != "thesis's, k_vol = 0" && m.name != "springs, nu = 0.45";
  });
  config.materials = config.stretched = config.models;
  config.tensions = {0.1};
  config.integrators = {"rk4"};
  config.step_shares = {0.4};
  return config;
}

std::string volume_rows(const studies::volume::VolumeConfig& config) {
  Progress progress;
  Journal journal;
  return studies::volume::measure_volume(config, 1, journal, progress).rows.csv();
}

/// Springs in which one corner of every cell has the sign of its y in eq. 3-7 wrong: + Z x X where - Z x X
/// belongs.
class FlippedSign final : public BodySystem<double> {
 public:
  FlippedSign(const Body& body, const Environment& environment)
      : BodySystem<double>(body, environment, mss::spectral_bound(body), 1),
        springs_(body, environment, {.threads = 1}) {}

  StoredEnergy stored_energy(const Field<double>& x) const override { return springs_.stored_energy(x); }
  const char* kernel_name() const override { return "flipped sign"; }
  void force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) override {
    springs_.force(t, x, v, f);
    constexpr int corner = 5;  // its sides are + - +
    body().for_each_cell([&](std::ptrdiff_t site) {
      const auto p = corners_of(body(), x, site);
      Vec3 along_x = Vec3::Zero(), along_z = Vec3::Zero();
      for (std::size_t c = 0; c < 8; ++c) {
        along_x += ((c & 1) != 0 ? 0.25 : -0.25) * p[c];
        along_z += ((c & 4) != 0 ? 0.25 : -0.25) * p[c];
      }
      const double excess = thesis_volume(p) / body().cell_volume() - 1;
      const std::ptrdiff_t at = site + body().lattice().corner(corner);
      f.set(at, f.at(at) - body().config().springs.volume * excess / 2 * along_z.cross(along_x));
    });
  }
  Tangents<double>* tangents() override { return springs_.tangents(); }

 private:
  SpringSystem<double> springs_;
};

TEST(Baselines, DetectASignFlippedInOneCornerOfEquation_3_7) {
  studies::volume::VolumeConfig config = small_volume_config();
  const std::string before = volume_rows(config);
  config.make = [](const std::string&, const Body& body, const Environment& environment) {
    return std::make_unique<FlippedSign>(body, environment);
  };
  const auto moved = compare(before, volume_rows(config), baseline_of("volume"));
  std::set<std::string> studies;
  for (const Deviation& d : moved) {
    EXPECT_NE(d.row.find("model = springs, nu = 0.45"), std::string::npos) << to_string(d);
    studies.insert(d.row.substr(0, d.row.find(',')));
  }
  EXPECT_EQ(studies, (std::set<std::string>{"study = cells", "study = strain", "study = twist",
                                            "study = tension", "study = free", "study = bounce"}));
}

TEST(Baselines, DetectAVolumeForceOfHalfTheStrength) {
  studies::volume::VolumeConfig config = small_volume_config();
  const std::string before = volume_rows(config);
  EXPECT_TRUE(compare(before, volume_rows(config), baseline_of("volume")).empty());
  // Inside the body, so that the table still says the whole of it.
  std::vector<std::unique_ptr<Body>> bodies;
  config.make = [&](const std::string&, const Body& body, const Environment& environment) {
    BodyConfig halved = body.config();
    halved.springs.volume /= 2;
    bodies.push_back(std::make_unique<Body>(halved));
    return std::make_unique<SpringSystem<double>>(*bodies.back(), environment, Execution{.threads = 1});
  };
  const auto moved = compare(before, volume_rows(config), baseline_of("volume"));
  ASSERT_FALSE(moved.empty());
  for (const Deviation& d : moved)
    EXPECT_NE(d.row.find("model = springs, nu = 0.45"), std::string::npos) << to_string(d);
}

TEST(Baselines, DetectAnotherStep) {
  const auto rows = [](double share) {
    studies::energy::EnergyConfig config = studies::energy::energy_config({});
    config.steps = 40;
    config.integrators = {"velocity_verlet", "rk4"};
    config.step_share = share;
    Progress progress;
    Journal journal;
    return studies::energy::measure_energy(config, 1, journal, progress).rows.csv();
  };
  const auto moved = compare(rows(0.25), rows(0.26), baseline_of("energy"));
  ASSERT_FALSE(moved.empty());
  EXPECT_EQ(moved.front().row, "integrator = velocity_verlet, step = 1");
  EXPECT_TRUE(
      std::any_of(moved.begin(), moved.end(), [](const Deviation& d) { return d.column == "energy_error"; }));
}

}  // namespace
}  // namespace mss::cli
