// What a window's session does without a window: the run of `mss run`, edits that keep the state, pulls,
// failures.
#include "experiments/view/session.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/error.hpp"
#include "core/device/device.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss::view {
namespace {

namespace fs = std::filesystem;

Scene scene(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return load_scene(scene_file(name), overrides);
}

double largest_difference(const Field<double>& a, const Field<double>& b) {
  return (a.array() - b.array()).abs().maxCoeff();
}

TEST(Session, GoesWhereMssRunGoesBitForBit) {
  for (const char* precision : {"double", "single"}) {
    const Scene s =
        scene("free_cube", {std::string("solve.precision='") + precision + "'", "solve.duration=0.2"});
    Progress silent;
    const SimulationResult run = simulate(s, silent);
    Session session(s);
    for (int frame = 0; frame < 12; ++frame) session.advance(1.0 / 60);
    EXPECT_EQ(session.steps(), run.work.steps);
    ASSERT_EQ(session.body().sites().size(), run.particles.size());
    for (std::size_t id = 0; id < run.particles.size(); ++id)
      ASSERT_EQ(session.positions().at(session.body().sites()[id]), run.particles[id].x) << precision;
  }
}

TEST(Session, SleepsAndIsStruckAsInMssRun) {
  const Scene s = scene("soft_blocks", {"solve.duration=3.3", "solve.threads=1"});
  Progress silent;
  const SimulationResult run = simulate(s, silent);
  Session session(s);
  while (session.time() < 3.299) session.advance(0.02);
  for (std::size_t id = 0; id < run.particles.size(); ++id)
    ASSERT_EQ(session.positions().at(session.body().sites()[id]), run.particles[id].x);
}

// Halfway between two states, then at the last for ever; from the start again.
TEST(Session, ShowsAMotionInPlaceOfASimulation) {
  const Scene s = scene("free_cube");
  const Body body(s.body);
  const Session simulated(s);
  State<double> first{.t = 0, .x = simulated.positions(), .v = simulated.velocities()}, last = first;
  last.t = 0.5;
  for (const std::ptrdiff_t site : body.sites()) last.x.set(site, first.x.at(site) + Vec3(0, 0, 2));
  Session session(s, {first, last});
  const std::ptrdiff_t site = body.sites().back();
  const Vec3 begin = session.positions().at(site);
  EXPECT_EQ(begin, first.x.at(site));
  session.advance(0.25);
  session.record();
  EXPECT_NEAR((session.positions().at(site) - begin - Vec3(0, 0, 1)).norm(), 0, 1e-12);
  session.advance(1);
  EXPECT_EQ(session.positions().at(site), last.x.at(site));
  EXPECT_EQ(session.status(), Status::ok);
  EXPECT_FALSE(session.grab(site));
  EXPECT_THROW(session.change(session.settings()), InputError);
  session.restart();
  EXPECT_EQ(session.positions().at(site), begin);
}

TEST(Session, ShowsEverySceneAndMethod) {
  int scenes = 0, methods = 0;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(fs::path(MSS_SOURCE_DIR) / "experiments" / "scenes")) {
    if (entry.path().extension() != ".toml") continue;
    Session session(load_scene(entry.path()));
    session.advance(0.05);
    session.record();
    EXPECT_EQ(session.status(), Status::ok) << entry.path();
    EXPECT_NEAR(session.time(), 0.05, 0.011) << entry.path();
    ++scenes;
  }
  EXPECT_GE(scenes, 14);
  for (const IntegratorInfo& info : integrators()) {
    if (info.stepping == Stepping::reduced) continue;  // bodies of its own: reduced_model_test.cpp
    Session session(scene("fig5_1_stretch", {"solve.integrator=" + info.name, "solve.dt=2e-4"}));
    session.advance(0.01);
    session.record();
    EXPECT_EQ(session.status(), Status::ok) << info.name;
    EXPECT_NEAR(session.time(), 0.01, 1.1e-4) << info.name;
    ++methods;
  }
  EXPECT_GE(methods, 10);
  Session elements(scene("cantilever", {"material.model=corotational", "body.cells=[4,2,2]"}));
  elements.advance(0.01);
  EXPECT_EQ(elements.status(), Status::ok);
}

// A pull weaker than friction must not move what rests on a plane, not even a little at every step.
TEST(Session, PullsInVainAtWhatSticks) {
  Session session(scene("fig5_2_rest"));
  session.advance(3);
  const std::ptrdiff_t corner = session.body().sites().front();
  const Vec3 before = session.positions().at(corner);
  ASSERT_TRUE(session.grab(corner));
  session.pull(before + Vec3(-1e-5, 0, 0));
  session.advance(1);
  EXPECT_LT((session.positions().at(corner) - before).norm(), 1e-9);
  session.pull(before + Vec3(-0.3, 0, 0));  // and a stronger one must
  session.advance(0.5);
  EXPECT_GT((session.positions().at(corner) - before).norm(), 0.01);
}

TEST(Session, TakesOneStepOfItsOwn) {
  Session session(scene("free_cube"));
  session.advance(0.0107);  // leaves a part of a step over
  const double before = session.time();
  session.step();
  EXPECT_NEAR(session.time() - before, session.dt(), 1e-12);
  EXPECT_EQ(session.steps(), std::lround(session.time() / session.dt()));
}

TEST(Session, KeepsPositionsAndVelocitiesWhenTheMaterialChanges) {
  Session session(scene("voxel_creature"));
  session.advance(0.1);
  const Field<double> x = session.positions(), v = session.velocities();
  const double t = session.time(), dt = session.dt();
  EXPECT_GT(v.array().abs().maxCoeff(), 0.1);
  SceneEdit settings = session.settings();
  settings.elastic->young *= 4;
  session.change(settings);
  EXPECT_EQ(session.time(), t);
  EXPECT_EQ(largest_difference(x, session.positions()), 0);
  EXPECT_EQ(largest_difference(v, session.velocities()), 0);
  EXPECT_NEAR(session.scene().body.springs.edge, 4 * scene("voxel_creature").body.springs.edge, 1e-6);
  EXPECT_LT(session.dt(), 0.55 * dt);  // "safe" follows the material
  session.step();                      // the new simulation continues from there
  const Field<double> moved = session.positions();
  double farthest = 0;
  for (const std::ptrdiff_t site : session.body().sites())
    farthest = std::max(farthest, (moved.at(site) - x.at(site) - session.dt() * v.at(site)).norm());
  EXPECT_GT(largest_difference(x, moved), 0);
  EXPECT_LT(farthest, 0.1 * session.dt() * v.array().abs().maxCoeff());
  session.change(edit_of(scene("voxel_creature")));
  EXPECT_EQ(session.dt(), dt);
}

TEST(Session, ChangesTopologyVolumeForceMethodAndStep) {
  Session session(scene("fig5_1_twist"));
  SceneEdit settings = session.settings();
  settings.volume_force = false;
  settings.topology = Topology::edges_body;
  settings.integrator = "rk4";
  settings.dt = 5e-4;
  settings.damping.zeta = 0.2;
  session.change(settings);
  EXPECT_EQ(session.scene().body.springs.volume, 0);
  EXPECT_LT(session.body().spring_count(), Body(scene("fig5_1_twist").body).spring_count());
  EXPECT_EQ(session.dt(), 5e-4);
  EXPECT_EQ(session.body().config().damping.zeta, 0.2);
  session.advance(0.01);
  EXPECT_EQ(session.steps(), 20);
  settings.volume_force = true;
  session.change(settings);
  EXPECT_EQ(session.scene().body.springs.volume, 0.1);
}

TEST(Session, RefusesWhatCannotBeSimulatedAndChangesNothing) {
  Session session(scene("cantilever"));
  session.advance(0.05);
  const Field<double> x = session.positions();
  SceneEdit settings = session.settings();
  settings.integrator = "explicit_euler";  // no step is safe
  settings.dt.reset();
  settings.damping = {};
  EXPECT_THROW(session.change(settings), InputError);
  EXPECT_EQ(session.settings().integrator, "verlet");
  EXPECT_EQ(largest_difference(x, session.positions()), 0);
  session.advance(0.05);
  EXPECT_EQ(session.status(), Status::ok);
}

TEST(Session, SurvivesAFailureAndRestarts) {
  Session session(scene("fig5_1_twist", {"solve.dt=0.02"}));  // ten times what is stable
  for (int frame = 0; frame < 600 && session.status() == Status::ok; ++frame) {
    session.advance(1.0 / 60);
    session.record();
  }
  EXPECT_EQ(session.status(), Status::non_finite);
  EXPECT_TRUE(std::isfinite(session.measures().kinetic));
  EXPECT_TRUE(session.positions().array().isFinite().all());
  const double t = session.time();
  session.advance(1);
  EXPECT_EQ(session.time(), t);  // nothing more happens
  SceneEdit settings = session.settings();
  settings.dt = 1e-3;
  session.change(settings);
  session.restart();
  EXPECT_EQ(session.status(), Status::ok);
  EXPECT_EQ(session.time(), 0);
  session.advance(0.5);
  EXPECT_EQ(session.status(), Status::ok);
  EXPECT_EQ(session.steps(), 500);
}

TEST(Session, IsPulledByAParticle) {
  Session session(scene("free_cube", {"start.velocity=[0,0,0]", "start.angular_velocity=[0,0,0]"}));
  const std::ptrdiff_t corner = session.body().sites().back();
  ASSERT_TRUE(session.grab(corner));
  const Vec3 here = session.positions().at(corner);
  EXPECT_EQ(session.pulled()->from, here);
  session.advance(0.05);
  EXPECT_LT(session.velocities().at(corner).norm(), 1e-9);  // tied to where it is: no pull yet
  session.pull(here + Vec3(0.2, 0, 0));
  session.advance(0.05);
  EXPECT_GT(session.positions().at(corner)[0] - here[0], 1e-3);
  session.release();
  EXPECT_FALSE(session.pulled());
  session.record();
  const double momentum = session.measures().momentum[0];
  EXPECT_GT(momentum, 1e-3);
  session.advance(0.05);
  session.record();
  EXPECT_NEAR(session.measures().momentum[0], momentum, 1e-9 * momentum);  // the pull has ended
}

TEST(Session, CannotBePulledWhereItIsHeld) {
  Session session(scene("cantilever"));
  EXPECT_FALSE(session.grab(session.body().sites().front()));
  EXPECT_FALSE(session.pulled());
}

TEST(Session, StopsAtItsBudget) {
  Session session(scene("free_cube"));
  EXPECT_NEAR(session.advance_within(0.64, 0), 0.01, 1e-12);
  EXPECT_NEAR(session.time(), 0.01, 1e-9);
  EXPECT_NEAR(session.advance_within(0.08, 1e9), 0.08, 1e-12);
  EXPECT_NEAR(session.time(), 0.09, 1e-9);
}

TEST(Session, RemembersMeasuresFromItsStart) {
  Session session(scene("free_cube"));
  EXPECT_EQ(session.history().size(), 1U);
  for (int i = 0; i < 5; ++i) {
    session.advance(1e-3);
    session.record();
  }
  EXPECT_EQ(session.history().size(), 6U);
  EXPECT_EQ(session.history().front().t, 0);
  EXPECT_NEAR(session.measures().total(), session.start().total(), 1e-3 * session.start().total());
  session.restart();
  EXPECT_EQ(session.history().size(), 1U);
}

/// Sessions whose steps a device takes; skipped where there is none.
class SessionOnDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      Device::open("gpu");
    } catch (const InputError& error) {
      GTEST_SKIP() << error.what();
    }
  }

  static Scene on(const std::string& device, const std::vector<std::string>& more = {}) {
    std::vector<std::string> settings{"solve.device='" + device + "'", "start.velocity=[0,0,0]",
                                      "start.angular_velocity=[0,0,1]"};
    settings.insert(settings.end(), more.begin(), more.end());
    return scene("free_cube", settings);
  }
};

TEST_F(SessionOnDevice, LeavesTheStateThereUntilSomeoneAsks) {
  for (const char* precision : {"solve.precision='double'", "solve.precision='single'"}) {
    const double rounding = precision[17] == 'd' ? 1e-10 : 1e-5;
    Session here(on("cpu", {precision})), there(on("gpu", {precision}));
    const long before = there.fetches();
    for (int frame = 0; frame < 6; ++frame) {
      here.advance(1.0 / 60);
      there.advance(1.0 / 60);
    }
    EXPECT_GT(there.body_on_device().index(), 0U);
    EXPECT_EQ(here.body_on_device().index(), 0U);
    EXPECT_EQ(there.time(), here.time());
    EXPECT_EQ(there.steps(), here.steps());
    EXPECT_EQ(there.fetches(), before);
    EXPECT_LT(largest_difference(here.positions(), there.positions()), rounding);
    EXPECT_LT(largest_difference(here.velocities(), there.velocities()), 1e2 * rounding);
    EXPECT_EQ(there.fetches(), before + 1);
    here.record();
    there.record();
    EXPECT_NEAR(there.measures().total() / here.measures().total(), 1, rounding);
    EXPECT_EQ(there.fetches(), before + 1);  // nothing has moved since
    there.advance(1.0 / 60);
    there.record();
    EXPECT_EQ(there.fetches(), before + 2);
  }
}

TEST_F(SessionOnDevice, IsPulledAndChangedAsOnTheProcessor) {
  for (const char* method : {"semi_implicit_euler", "verlet", "rk4", "xpbd", "vbd"}) {
    const std::string integrator = std::string("solve.integrator=") + method;
    Session here(on("cpu", {integrator})), there(on("gpu", {integrator}));
    for (Session* session : {&here, &there}) {
      session->advance(0.01);
      const std::ptrdiff_t corner = session->body().sites().back();
      ASSERT_TRUE(session->grab(corner));
      session->pull(session->positions().at(corner) + Vec3(0.3, 0, 0.1));
      session->advance(0.01);
      session->pull(session->positions().at(corner) + Vec3(0, 0.2, 0));
      session->advance(0.01);
      SceneEdit settings = session->settings();
      settings.damping = {.law = Damping::Law::ratio, .zeta = 0.1};
      session->change(settings);
      session->advance(0.01);
      session->release();
      session->advance(0.01);
    }
    EXPECT_LT(largest_difference(here.positions(), there.positions()), 1e-10) << method;
    Session alone(on("gpu", {integrator}));
    alone.advance(0.05);
    EXPECT_GT(largest_difference(there.positions(), alone.positions()), 1e-4) << method;
    SceneEdit settings = there.settings();
    settings.device = "cpu";
    there.change(settings);
    EXPECT_EQ(there.body_on_device().index(), 0U);
    EXPECT_LT(largest_difference(here.positions(), there.positions()), 1e-10) << method;
  }
}

TEST_F(SessionOnDevice, ShowsWhatWasFetchedLastAfterAFailure) {
  Session session(on("gpu", {"solve.dt=0.02"}));  // many times what is stable
  for (int frame = 0; frame < 600 && session.status() == Status::ok; ++frame) {
    session.advance(1.0 / 60);
    if (frame == 1) session.record();
  }
  EXPECT_EQ(session.status(), Status::non_finite);
  EXPECT_EQ(session.body_on_device().index(), 0U);
  EXPECT_TRUE(session.positions().array().isFinite().all());
  EXPECT_EQ(session.time(), session.measures().t);
  SceneEdit settings = session.settings();
  settings.dt.reset();
  session.change(settings);
  session.restart();
  session.advance(0.1);
  EXPECT_EQ(session.status(), Status::ok);
}

TEST_F(SessionOnDevice, SaysAtOnceWhatADeviceCannotDo) {
  Session session(on("cpu", {"material.relaxation={ratio=0.5, time=0.1}"}));
  SceneEdit settings = session.settings();
  settings.device = "gpu";
  const auto refusal = [&] {
    try {
      session.change(settings);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal().find("a device does not do material.relaxation"), std::string::npos) << refusal();
  settings.integrator = "backward_euler";
  EXPECT_NE(refusal().find("takes no steps on a device"), std::string::npos) << refusal();
  EXPECT_EQ(session.settings().device, "cpu");
  session.advance(0.01);
  EXPECT_EQ(session.status(), Status::ok);
}

TEST_F(SessionOnDevice, IsStruckAsOnTheProcessor) {
  const std::vector<std::string> strike{"strike=[{box=[[-9,-9,-9],[9,9,9]], at=0.05, impulse=[200,0,0]}]"};
  Session here(on("cpu", strike)), there(on("gpu", strike));
  for (Session* session : {&here, &there})
    for (int frame = 0; frame < 6; ++frame) session->advance(1.0 / 60);
  EXPECT_LT(largest_difference(here.positions(), there.positions()), 1e-10);
  there.record();
  EXPECT_NEAR(there.measures().momentum[0], 200, 1e-6);
}

}  // namespace
}  // namespace mss::view
