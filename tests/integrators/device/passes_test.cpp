// Methods that step by passes over colours, on a device against the processor.
#include "core/base/error.hpp"
#include "core/base/record.hpp"
#include "core/device/device.hpp"
#include "tests/integrators/device/on_device.hpp"

namespace mss {
namespace {

using testing::Driven;

const Vec3 pull(0.3, -0.2, -9.81);

/// Held along some axes only, and moving; loads that change.
Environment held_and_loaded() {
  Environment environment{.gravity = pull};
  environment.holds.push_back({.box = {Vec3(-1, -1, -1), Vec3(0.31, 2, 2)},
                               .axes = {true, false, true},
                               .velocity = Vec3(0.1, 0, 0.2)});
  environment.holds.push_back(
      {.box = {Vec3(0.4, -1, 0.45), Vec3(0.8, 2, 0.55)}, .axes = {false, true, true}});
  environment.loads.push_back({.box = {Vec3(1, -1, -1), Vec3(9, 9, 9)},
                               .force = Vec3(3, 1, 2),
                               .history = {{{0, 0}, {0.05, 1}, {0.1, 0.3}}}});
  return environment;
}

template <class Real>
struct HereAndThere {
  Driven<Real> here, there;
  State<Real> before;

  HereAndThere(const BodyConfig& config, const Environment& environment, const std::string& method,
               IntegratorOptions options, double amplitude)
      : here(config, environment, method, options),
        there(config, environment, method, on_device(options)),
        before(here.state) {
    testing::randomise(here.body, here.state, amplitude, 0.5, 3);
    here.system.constrain(0, here.state.x, here.state.v);
    before = there.state = here.state;
  }

  /// The largest difference of a position after so many steps, over the largest way.
  double difference_after(int steps, double dt) {
    EXPECT_EQ(there.advance(steps * dt), Status::ok);
    EXPECT_EQ(here.advance(steps * dt), Status::ok);
    EXPECT_EQ(there.work.force_evaluations, here.work.force_evaluations);
    const double way = testing::largest_difference(here.body, here.state.x, before.x);
    EXPECT_GT(way, 0);
    return testing::largest_difference(here.body, here.state.x, there.state.x) / way;
  }

  static IntegratorOptions on_device(IntegratorOptions options) {
    options.device = "gpu";
    return options;
  }
};

/// Bodies of every kind that these methods step: shapes, damped or not, ragged fills of several parts.
std::vector<std::pair<std::string, BodyConfig>> bodies_for_passes() {
  std::vector<std::pair<std::string, BodyConfig>> all;
  for (const auto& shape : testing::test_shapes()) {
    BodyConfig config = testing::test_config(shape.voxels);
    all.emplace_back(shape.name, config);
    testing::add_parts(config);
    testing::fill_randomly(config, 5);
    all.emplace_back(shape.name + " of parts", config);
  }
  return all;
}

/// Of velocities: positions are rounded to their own last digit, which says nothing of the step.
template <class Real>
double error_of_a_pass(const BodyConfig& config, const Environment& environment, const std::string& method) {
  HereAndThere<Real> pair(config, environment, method, {.dt = 1e-2}, 0.3);
  EXPECT_EQ(pair.there.advance(1e-2), Status::ok);
  EXPECT_EQ(pair.here.advance(1e-2), Status::ok);
  double fastest = 0;
  for (const std::ptrdiff_t site : pair.here.body.sites())
    fastest = std::max(fastest, pair.here.state.v.at(site).template cast<double>().norm());
  EXPECT_GT(fastest, 0);
  return testing::largest_difference(pair.here.body, pair.here.state.v, pair.there.state.v) / fastest;
}

TEST(DevicePasses, OneStepEqualsTheProcessors) {
  for (const auto& [name, config] : bodies_for_passes()) {
    const bool is_plain = config.contents.empty();
    const Environment environment = is_plain ? Environment{.gravity = pull} : held_and_loaded();
    for (const std::string method : {"xpbd", "vbd"}) {
      const std::string variant = is_plain ? method : method + ":5";
      EXPECT_LT(error_of_a_pass<double>(config, environment, variant), 1e-13) << variant << name;
      EXPECT_LT(error_of_a_pass<float>(config, environment, variant), 1e-6) << variant << name;
    }
  }
}

/// Their springs lie in one plane or line, and sites beyond have no particle.
TEST(DevicePasses, OneStepOfSheetsAndRopesToo) {
  for (const VoxelGrid& voxels : {VoxelGrid::box(6, 5, 0), VoxelGrid::box(7, 0, 0)})
    for (const std::string method : {"xpbd", "vbd"}) {
      BodyConfig config = testing::test_config(voxels);
      config.springs.volume = 0;
      EXPECT_LT(error_of_a_pass<double>(config, {.gravity = pull}, method), 1e-13) << method;
    }
}

/// A box is among the tests of all methods, with one pass a step.
TEST(DevicePasses, FollowTheProcessorsFor200Steps) {
  const double dt = 1e-3;
  const BodyConfig config = testing::mixed_config(testing::test_shapes().back().voxels, 5);
  for (const std::string method : {"xpbd:5", "vbd:5"}) {
    HereAndThere<double> fine(config, held_and_loaded(), method, {.dt = dt}, 0.1);
    EXPECT_LT(fine.difference_after(200, dt), 1e-10) << method;
    HereAndThere<float> coarse(config, held_and_loaded(), method, {.dt = dt}, 0.1);
    EXPECT_LT(coarse.difference_after(200, dt), 1e-4) << method;
  }
}

TEST(DevicePasses, AreAcceleratedAlike) {
  const BodyConfig config = testing::mixed_config(VoxelGrid::box(4, 3, 3), 5);
  HereAndThere<double> pair(config, held_and_loaded(), "vbd:5", {.dt = 5e-3, .chebyshev_radius = 0.7}, 0.1);
  EXPECT_LT(pair.difference_after(40, 5e-3), 1e-10);
  HereAndThere<double> plain(config, held_and_loaded(), "vbd:5", {.dt = 5e-3}, 0.1);
  plain.difference_after(40, 5e-3);
  EXPECT_GT(testing::largest_difference(plain.here.body, plain.there.state.x, pair.there.state.x), 1e-6);
}

/// Two planes at an angle; some particles are behind the second at the beginning.
Environment wedge(double restitution) {
  Environment environment{.gravity = pull};
  environment.planes.push_back({.point = Vec3(0.6, 0.2, 0.4),
                                .normal = Vec3(0.1, 0.2, 1).normalized(),
                                .restitution = restitution,
                                .friction = 0.4});
  environment.planes.push_back(
      {.point = Vec3(1.05, 0, 0.45), .normal = Vec3(-1, 0, 0.3).normalized(), .restitution = restitution});
  return environment;
}

Vec3 given_by(Driven<double>& driven, std::size_t plane) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : driven.body.sites())
    sum += driven.system.plane_impulses()->at(plane, site);
  return sum;
}

/// One that is held across y, where planes push along it too; or free.
void expect_same_contact(const std::string& method, double restitution, bool held) {
  const double dt = 2e-3;
  Environment environment = wedge(restitution);
  if (held)
    environment.holds.push_back({.box = {Vec3(-1, -1, -1), Vec3(9, 0, 9)}, .axes = {false, true, false}});
  HereAndThere<double> pair(testing::mixed_config(VoxelGrid::box(4, 3, 3), 5), environment, method,
                            {.dt = dt}, 0.1);
  EXPECT_LT(pair.difference_after(60, dt), 1e-10);
  for (const std::size_t plane : {0U, 1U}) {
    const Vec3 here = given_by(pair.here, plane), there = given_by(pair.there, plane);
    EXPECT_GT(here.norm(), 0.1);
    EXPECT_LT((here - there).norm(), 1e-9 * here.norm());
  }
}

TEST(DevicePasses, MeetPlanesAsOnTheProcessor) {
  for (const std::string method : {"xpbd", "xpbd:5", "vbd", "vbd:5"}) {
    SCOPED_TRACE(method);
    expect_same_contact(method, 0, false);
    expect_same_contact(method, 0.6, true);
  }
}

/// A stiff body, whose one pass a step cannot spread an impact: its guesses are shortened.
TEST(DevicePasses, ShortenGuessesOfImpactsAlike) {
  const double dt = 1e-2;
  BodyConfig config = testing::test_config(VoxelGrid::box(4, 3, 3));
  config.springs = {.edge = 1e6, .face = 1e6, .body = 1e6, .volume = 1e6};
  Environment environment{.gravity = pull};
  environment.planes.push_back({.point = Vec3(0, 0, 0.5), .restitution = 0.3, .friction = 0.4});
  environment.planes.push_back({.point = Vec3(-50, 0, 0), .normal = Vec3::UnitX()});
  HereAndThere<double> pair(config, environment, "vbd", {.dt = dt}, 0);
  for (const int steps : {1, 2, 20}) {  // what lies on the plane already comes to it no more
    for (const std::ptrdiff_t site : pair.here.body.sites()) {
      pair.here.state.v.set(site, Vec3(0.5, 0, -4));
      pair.there.state.v.set(site, Vec3(0.5, 0, -4));
    }
    EXPECT_LT(pair.difference_after(steps, dt), 1e-10) << steps;
  }
}

TEST(DevicePasses, XpbdKeepsLinearMomentum) {
  const double dt = 5e-3;
  for (const std::string method : {"xpbd", "xpbd:5"}) {
    Driven<double> driven(testing::mixed_config(VoxelGrid::box(4, 3, 3), 5), {.gravity = pull}, method,
                          {.dt = dt, .device = "gpu"});
    testing::randomise(driven.body, driven.state, 0.3, 0.5, 3);
    const auto momentum = [&] {
      Vec3 sum = Vec3::Zero();
      for (const std::ptrdiff_t site : driven.body.sites())
        sum += driven.body.mass(site) * driven.state.v.at(site);
      return sum;
    };
    const Vec3 before = momentum();
    EXPECT_EQ(driven.advance(20 * dt), Status::ok);
    const Vec3 expected = before + driven.body.total_mass() * 20 * dt * pull;
    EXPECT_LT((momentum() - expected).norm(), 1e-12 * expected.norm()) << method;
  }
}

/// Of positions and velocities after some steps.
std::vector<float> bits_after(const std::string& method, const Environment& environment, int steps,
                              bool stops_between) {
  const double dt = 2e-3;
  const IntegratorOptions options{.dt = dt, .device = "gpu"};
  Driven<float> driven(testing::mixed_config(VoxelGrid::box(4, 3, 3), 5), environment, method, options);
  testing::randomise(driven.body, driven.state, 0.1, 0.5, 3);
  if (stops_between) {
    const int half = steps / 2;
    EXPECT_EQ(driven.advance(half * dt), Status::ok);
    Record written;
    driven.method->remember(driven.system, written);
    driven.method = find_integrator(method).make<float>(options);
    Record read(written.take_bytes());
    driven.method->remember(driven.system, read);
    EXPECT_TRUE(read.at_end());
  }
  EXPECT_EQ(driven.advance(steps * dt), Status::ok);
  std::vector<float> bits;
  for (const std::ptrdiff_t site : driven.body.sites())
    for (const Field<float>* field : {&driven.state.x, &driven.state.v})
      for (int axis = 0; axis < 3; ++axis) bits.push_back(field->axis(axis)[site]);
  return bits;
}

std::vector<std::pair<std::string, Environment>> pass_scenes() {
  return {{"xpbd:5", wedge(0.6)}, {"vbd:5", wedge(0.6)}};
}

TEST(DevicePasses, AreTheSameBitsInEveryRun) {
  for (const auto& [method, environment] : pass_scenes()) {
    const std::vector<float> first = bits_after(method, environment, 10, false);
    for (int run = 1; run < 10; ++run) EXPECT_EQ(bits_after(method, environment, 10, false), first) << method;
  }
}

TEST(DevicePasses, AreTheSameBitsForAnyWorkGroup) {
  const std::shared_ptr<Device> device = Device::open("gpu");
  const int usual = device->group_size();
  for (const auto& [method, environment] : pass_scenes()) {
    const std::vector<float> first = bits_after(method, environment, 10, false);
    for (const int size : {32, 128}) {
      device->set_group_size(size);
      EXPECT_EQ(bits_after(method, environment, 10, false), first) << method << size;
    }
    device->set_group_size(usual);
  }
}

TEST(DevicePasses, GoOnFromARecordWithTheSameBits) {
  for (const auto& [method, environment] : pass_scenes())
    EXPECT_EQ(bits_after(method, environment, 10, true), bits_after(method, environment, 10, false))
        << method;
}

TEST(DevicePasses, RefuseWhatTheProcessorsRefuse) {
  BodyConfig guarded = testing::test_config(VoxelGrid::box(2, 2, 2));
  guarded.fold_guard = 400;
  for (const std::string method : {"xpbd", "vbd"}) {
    Driven<double> driven(guarded, {.gravity = pull}, method, {.dt = 1e-3, .device = "gpu"});
    EXPECT_THROW(driven.advance(1e-3), InputError) << method;
  }
}

}  // namespace
}  // namespace mss
