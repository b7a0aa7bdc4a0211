// What a device is: the same bits from run to run, statuses, refusals.
#include "core/device/device.hpp"

#include <epoxy/gl.h>
#include <gmock/gmock.h>

#include <cstring>

#include "core/base/error.hpp"
#include "core/base/record.hpp"
#include "core/system/plane_impulses.hpp"
#include "integrators/device/state_on_device.hpp"
#include "tests/integrators/device/on_device.hpp"

namespace mss {
namespace {

using testing::Driven;

/// A guarded body of parts that turns, falls on a slope and is pulled, after some steps.
template <class Real>
State<Real> state_after(long steps, const std::string& method) {
  BodyConfig config = testing::test_config(VoxelGrid::box(5, 3, 4));
  config.fold_guard = 400;
  testing::add_parts(config);
  testing::fill_randomly(config, 5);
  Environment environment{.gravity = {0.3, 0, -9.81}, .planes = {{.point = Vec3(0, 0, 0.45)}}};
  environment.loads.push_back({.box = {Vec3(1, -1, -1), Vec3(9, 9, 9)}, .force = Vec3(3, 1, 2)});
  Driven<Real> driven(config, environment, method, {.dt = 1e-3, .device = "gpu"});
  testing::randomise(driven.body, driven.state, 0.2, 0.5, 3);
  EXPECT_EQ(driven.advance(double(steps) * 1e-3), Status::ok);
  return driven.state;
}

template <class Real>
bool are_equal(const State<Real>& a, const State<Real>& b) {
  const auto equal = [](const Field<Real>& f, const Field<Real>& g) {
    return std::memcmp(f.axis(0), g.axis(0), std::size_t(f.size()) * sizeof(Real)) == 0;
  };
  return a.t == b.t && equal(a.x, b.x) && equal(a.v, b.v);
}

/// Restores what it was made with.
class GroupSize {
 public:
  explicit GroupSize(int threads) : before_(device_->group_size()) { device_->set_group_size(threads); }
  ~GroupSize() { device_->set_group_size(before_); }
  GroupSize(const GroupSize&) = delete;
  GroupSize& operator=(const GroupSize&) = delete;

 private:
  std::shared_ptr<Device> device_ = Device::open("gpu");
  int before_;
};

template <class Real>
void expect_the_same_bits(const std::string& method) {
  const State<Real> first = state_after<Real>(40, method);
  for (int run = 1; run < 10; ++run) {
    const GroupSize size(run % 2 == 0 ? 32 : 128);
    EXPECT_TRUE(are_equal(first, state_after<Real>(40, method))) << method << " run " << run;
  }
}

TEST(DeviceBits, AreTheSameInTenRunsAndForAllWorkGroups) {
  expect_the_same_bits<double>("velocity_verlet");
  expect_the_same_bits<float>("semi_implicit_euler");
}

TEST(DeviceSteps, DependOnWhereAnAdvanceEndsByRoundingOnly) {
  BodyConfig config = testing::test_config(VoxelGrid::box(4, 3, 3));
  for (const char* method : {"velocity_verlet", "damped_verlet", "rk4", "explicit_euler"}) {
    Driven<double> once(config, {}, method, {.dt = 1e-3, .device = "gpu"}),
        often(config, {}, method, {.dt = 1e-3, .device = "gpu"});
    testing::randomise(once.body, once.state, 0.2, 0.5, 3);
    often.state = once.state;
    ASSERT_EQ(once.advance(0.03), Status::ok);
    for (const double t : {0.001, 0.01, 0.011, 0.03}) ASSERT_EQ(often.advance(t), Status::ok);
    EXPECT_LT(testing::largest_difference(once.body, once.state.x, often.state.x), 1e-13) << method;
  }
}

Vec3 given_by_plane(const Driven<double>& driven) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : driven.body.sites()) sum += driven.system.plane_impulses()->at(0, site);
  return sum;
}

/// Another process goes on with the same bits, also where particles stick to a plane.
TEST(DeviceBits, GoOnFromARecord) {
  const BodyConfig config = testing::test_config(VoxelGrid::box(4, 3, 3));
  const Environment lying{.gravity = {0.5, 0, -9.81},
                          .planes = {{.point = Vec3(0, 0, 0.5), .friction = 0.6}}};
  for (const char* method : {"semi_implicit_euler", "velocity_verlet", "damped_verlet"}) {
    const auto make = [&] {
      return std::make_unique<Driven<double>>(config, lying, method,
                                              IntegratorOptions{.dt = 1e-3, .device = "gpu"});
    };
    const auto first = make(), second = make();
    ASSERT_EQ(first->advance(0.3), Status::ok);
    Record kept;
    first->system.remember(kept);
    first->method->remember(first->system, kept);
    Record found(kept.take_bytes());
    second->system.remember(found);
    second->method->remember(second->system, found);
    second->state = first->state;
    const Vec3 before = given_by_plane(*first);
    ASSERT_EQ(first->advance(0.34), Status::ok);
    ASSERT_EQ(second->advance(0.34), Status::ok);
    EXPECT_TRUE(are_equal(first->state, second->state)) << method;
    EXPECT_EQ(given_by_plane(*first), given_by_plane(*second)) << method;
    EXPECT_GT((given_by_plane(*first) - before)[2], 1) << method;
  }
}

TEST(DeviceStatus, SaysThatStepsDiverge) {
  const BodyConfig config = testing::test_config(VoxelGrid::box(3, 3, 3));
  Driven<float> driven(config, {}, "explicit_euler", {.dt = 1, .device = "gpu"});
  testing::randomise(driven.body, driven.state, 0.2, 0.5, 3);
  EXPECT_EQ(driven.advance(400), Status::non_finite);
  EXPECT_LT(driven.state.t, 400);
}

int calls_before_reset = 0;
GLenum reset_after_some_calls() { return calls_before_reset-- > 0 ? GL_NO_ERROR : GL_UNKNOWN_CONTEXT_RESET; }

/// What a reset of the driver looks like, without one, while it lives: after so many questions.
class Reset {
 public:
  explicit Reset(int calls) {
    calls_before_reset = calls;
    epoxy_glGetGraphicsResetStatus = reset_after_some_calls;
  }
  ~Reset() { epoxy_glGetGraphicsResetStatus = honest_; }
  Reset(const Reset&) = delete;
  Reset& operator=(const Reset&) = delete;

 private:
  PFNGLGETGRAPHICSRESETSTATUSPROC honest_ = epoxy_glGetGraphicsResetStatus;
};

const Environment on_a_plane{.gravity = {0, 0, -9.81}, .planes = {{.point = Vec3(0, 0, 0.5)}}};

Driven<double> lying_body() {
  return {testing::test_config(VoxelGrid::box(3, 3, 3)),
          on_a_plane,
          "velocity_verlet",
          {.dt = 1e-3, .device = "gpu"}};
}

TEST(DeviceStatus, SaysThatTheDeviceWasLostAndKeepsTheState) {
  for (const int calls : {0, 1, 3}) {  // at the first question, later, and while the state is carried back
    Driven<double> driven = lying_body();
    ASSERT_EQ(driven.advance(0.1), Status::ok);
    const State<double> before = driven.state;
    const Vec3 given = given_by_plane(driven);
    {
      const Reset reset(calls);
      EXPECT_EQ(driven.advance(0.19), Status::device_lost) << calls;
    }
    EXPECT_TRUE(are_equal(before, driven.state)) << calls;
    EXPECT_EQ(given_by_plane(driven), given) << calls;
    EXPECT_EQ(driven.advance(0.2), Status::device_lost) << calls;
    // The next one that asks for it gets it anew.
    Driven<double> again = lying_body();
    EXPECT_EQ(again.advance(0.1), Status::ok);
  }
}

/// A method that has left the state there has that of the last time that it was fetched, time included.
TEST(DeviceStatus, SaysThatTheDeviceWasLostWithTheState) {
  for (const bool in_fetch : {false, true}) {
    Driven<double> driven = lying_body();
    auto& left = dynamic_cast<StateOnDevice<double>&>(*driven.method);
    left.leave_there();
    ASSERT_EQ(driven.advance(0.05), Status::ok);
    ASSERT_EQ(left.fetch(driven.state), Status::ok);
    const State<double> before = driven.state;
    ASSERT_EQ(driven.advance(0.1), Status::ok);
    EXPECT_EQ(driven.state.t, 0.1);
    const Reset reset(0);
    EXPECT_EQ(in_fetch ? left.fetch(driven.state) : driven.advance(0.2), Status::device_lost);
    EXPECT_TRUE(are_equal(before, driven.state)) << in_fetch;
  }
}

std::string refusal(const std::string& method, const Environment& environment, const BodyConfig& config,
                    const std::string& device = "gpu") {
  try {
    Driven<double> driven(config, environment, method, {.dt = 1e-3, .device = device});
    static_cast<void>(driven.advance(0.01));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void GLAPIENTRY do_nothing(GLuint, GLuint, GLuint) {}

/// As one was seen to: whatever it was asked for, nothing moved.
TEST(DeviceRefuses, ADriverThatComputesOtherForces) {
  Device::open("gpu");  // where it is there
  const auto honest = epoxy_glDispatchCompute;
  epoxy_glDispatchCompute = do_nothing;
  const std::string said =
      refusal("verlet", {.gravity = {0, 0, -9.81}}, testing::test_config(VoxelGrid::box(3, 3, 3)));
  epoxy_glDispatchCompute = honest;
  EXPECT_THAT(said,
              ::testing::HasSubstr("computes accelerations of this body that are off by 1 of the largest"));
}

TEST(DeviceRefuses, WhatItDoesNotDo) {
  using ::testing::HasSubstr;
  const BodyConfig config = testing::test_config(VoxelGrid::box(3, 3, 3));
  BodyConfig relaxing = config;
  relaxing.relaxation = {.ratio = 0.5, .time = 0.1};
  EXPECT_THAT(refusal("tr_bdf2", {}, config), HasSubstr("takes no steps on a device; give one of"));
  EXPECT_THAT(refusal("verlet", {}, relaxing), HasSubstr("a device does not do material.relaxation"));
  EXPECT_THAT(refusal("verlet", {.planes = {{.contact = ContactLaw::penalty}}}, config),
              HasSubstr("planes of another law than \"impulse\""));
  EXPECT_THAT(refusal("verlet", {.planes = {{.contact = ContactLaw::thesis}}}, config),
              HasSubstr("planes of another law than \"impulse\""));
  EXPECT_THAT(refusal("pefrl", {}, config), HasSubstr("takes no steps on a device"));
  BodyConfig guarded = config;
  guarded.fold_guard = 400;
  EXPECT_THAT(refusal("vbd", {}, guarded), HasSubstr("has no local solution for fold_guard"));
  EXPECT_THAT(refusal("verlet", {}, config, "gpu:99"), HasSubstr("device 'gpu:99' is not there"));
  EXPECT_THAT(refusal("verlet", {}, config, "card"), HasSubstr("device 'card' is unknown; give"));
}

}  // namespace
}  // namespace mss
