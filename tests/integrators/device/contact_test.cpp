// Planes of the law `impulse` on a device against the processor's: blocks that rest, carry, slide, fall and
// lie in a groove, as in the study of contact, and ragged ones; what planes give is counted alike.
#include <cmath>
#include <numbers>

#include "core/system/plane_impulses.hpp"
#include "tests/integrators/device/on_device.hpp"

namespace mss {
namespace {

using testing::Driven;

struct ContactScene {
  std::string name;
  double degrees = 0;  ///< by which gravity is inclined
  double height = 0;   ///< from which the body falls [m]
  double friction = 0;
  bool groove = false;
  double burden = 0;  ///< on its top, over its mass
};
const std::vector<ContactScene> scenes{{"rest", 0, 0, 0.5},    {"loaded", 0, 0, 0.5, false, 1},
                                       {"slide", 30, 0, 0.2},  {"stick", 10, 0, 0.5},
                                       {"drop", 0, 0.05, 0.5}, {"groove", 30, 0, 0.3, true}};

BodyConfig block_of(const ContactScene& scene, bool ragged) {
  VoxelGrid voxels(4, 3, 3);
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 4; ++i) voxels.set(i, j, k, !ragged || i + j + k != 7);
  BodyConfig config{.voxels = voxels, .cell_size = 0.1};
  config.fill({.young = 2e4, .poisson = 0.3}, 0.5);
  config.damping = {.law = Damping::Law::ratio, .zeta = 0.2};
  if (scene.burden > 0)
    config.weights = {{.box = {Vec3(-1, -1, 0.299), Vec3(1, 1, 1)}, .mass = scene.burden * 36}};
  if (ragged) testing::add_parts(config), testing::fill_randomly(config, 3);
  return config;
}

Environment environment_of(const ContactScene& scene) {
  const double angle = scene.degrees * std::numbers::pi / 180;
  Environment environment{
      .gravity = 9.81 * Vec3((scene.groove ? -1 : 1) * std::sin(angle), 0, -std::cos(angle)),
      .planes = {{.normal = Vec3::UnitZ(), .friction = scene.friction}}};
  if (scene.groove) environment.planes.push_back({.normal = Vec3::UnitX(), .friction = scene.friction});
  return environment;
}

template <class Real>
Vec3 centre_of_mass(const Driven<Real>& driven) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : driven.body.sites())
    sum += driven.body.mass(site) / driven.body.total_mass() * driven.state.x.at(site);
  return sum;
}

/// What one looks at, at the end.
struct Figures {
  Vec3 centre = Vec3::Zero();
  std::vector<Vec3> given{};  ///< by planes [N s]
  double lowest = 0;
};

template <class Real>
Figures figures_of(const ContactScene& scene, bool ragged, const std::string& method,
                   const std::string& device) {
  constexpr double dt = 1e-3, end = 0.3;
  Driven<Real> driven(block_of(scene, ragged), environment_of(scene), method, {.dt = dt, .device = device});
  for (const std::ptrdiff_t site : driven.body.sites())
    driven.state.x.set(site, driven.state.x.at(site) + scene.height * Vec3::UnitZ());
  EXPECT_EQ(driven.advance(end / 2), Status::ok);  // in two parts: what planes gave is carried over
  EXPECT_EQ(driven.advance(end), Status::ok);
  Figures figures{.centre = centre_of_mass(driven)};
  const PlaneImpulses& impulses = *driven.system.plane_impulses();
  for (std::size_t p = 0; p < impulses.planes(); ++p) {
    figures.given.emplace_back(Vec3::Zero());
    for (const std::ptrdiff_t site : driven.body.sites()) figures.given.back() += impulses.at(p, site);
  }
  for (const std::ptrdiff_t site : driven.body.sites())
    figures.lowest = std::min(figures.lowest, driven.state.x.at(site)[2]);
  return figures;
}

template <class Real>
void expect_the_same(const ContactScene& scene, bool ragged, const std::string& method) {
  const Figures here = figures_of<Real>(scene, ragged, method, "cpu"),
                there = figures_of<Real>(scene, ragged, method, "gpu");
  const std::string what = scene.name + (ragged ? " ragged " : " ") + method;
  EXPECT_LT((here.centre - there.centre).norm(), 0.01 * 0.1) << what;  // of a cell
  EXPECT_GT(here.given[0][2], 1) << what;
  for (std::size_t p = 0; p < here.given.size(); ++p)
    EXPECT_LT((here.given[p] - there.given[p]).norm(), 0.01 * here.given[p].norm()) << what << " plane " << p;
  EXPECT_NEAR(there.lowest, here.lowest, 1e-6) << what;
}

TEST(DeviceContact, HasTheProcessorsFigures) {
  for (const ContactScene& scene : scenes)
    for (const char* method : {"semi_implicit_euler", "velocity_verlet", "rk4"})
      expect_the_same<double>(scene, false, method);
}

TEST(DeviceContact, OfRaggedBodiesInSinglePrecisionToo) {
  for (const ContactScene& scene : {scenes[0], scenes[2], scenes[5]})
    for (const char* method : {"explicit_euler", "damped_verlet"}) {
      expect_the_same<double>(scene, true, method);
      expect_the_same<float>(scene, true, method);
    }
}

}  // namespace
}  // namespace mss
