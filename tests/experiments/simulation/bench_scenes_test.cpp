// Scenes that studies share: each does what it is meant to do, and what does not is told; what "stable"
// means.
#include "experiments/simulation/bench_scenes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <set>
#include <stdexcept>

namespace mss {
namespace {

TEST(BenchScenes, DoWhatTheyAreMeantToDo) {
  for (const BenchScene& scene : bench_scenes())
    for (const double young : bench_moduli)
      for (const double ratio : bench_ratios) {
        SCOPED_TRACE(scene.name + " " + std::to_string(young) + " " + std::to_string(ratio));
        const BenchBody body(scene, 4, {young, damping_of_ratio(ratio)});
        const TrueMotion truth = find_true_motion(body);
        EXPECT_EQ(truth.complaint, "");
        EXPECT_EQ(truth.positions.size(), std::size_t(scene.frames));
        EXPECT_LT(truth.uncertainty, 0.01);
        EXPECT_GT(truth.uncertainty, 0);
        EXPECT_LE(truth.extremes.energy, 1.001 * supplied_energy(truth.extremes));  // nothing else supplies
        EXPECT_EQ(out_of_bounds(truth.extremes, truth.extremes, body.body.config().cell_size), "");
      }
}

/// A motion in which all particles are moved by a map of their first positions and of time.
template <class Map>
FramePositions planted_motion(const BenchBody& body, Map&& map) {
  FramePositions motion;
  for (int i = 1; i <= body.scene.frames; ++i) {
    motion.push_back(body.start.x);
    for (const std::ptrdiff_t site : body.body.sites())
      motion.back().set(site, map(body.start.x.at(site), i * frame));
  }
  return motion;
}

TEST(BenchScenes, HaveANameForEveryMaterial) {
  const std::vector<std::string> names = bench_case_names();
  EXPECT_EQ(names.size(), bench_scenes().size() * bench_moduli.size() * bench_ratios.size());
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  const BenchCase& which = find_bench_case("slope_stiff_damped");
  EXPECT_EQ(which.scene, "slope");
  EXPECT_EQ(which.young, 1e7);
  EXPECT_EQ(which.ratio, 0.5);
  EXPECT_THROW(find_bench_case("slope"), std::logic_error);
}

BenchBody small_bench(const char* scene) {
  return {find_bench_scene(scene), 3, {1e6, damping_of_ratio(0.5)}};
}

TEST(BenchScenes, TellWhatWentWrong) {
  const auto stays = [](const Vec3& x, double) { return x; };
  const BenchBody box = small_bench("held_box"), ball = small_bench("ball"), spin = small_bench("spin"),
                  slope = small_bench("slope");
  EXPECT_EQ(bench_complaint(box, planted_motion(box, stays)), "the body has not sagged");
  EXPECT_EQ(bench_complaint(box, {}), "there is no motion");
  const auto falls = [](const Vec3& x, double t) -> Vec3 {
    return x - (1.5 * t + 9.81 / 2 * t * t) * Vec3::UnitZ();
  };
  EXPECT_EQ(bench_complaint(ball, planted_motion(ball, falls)), "the body is behind a plane");
  EXPECT_EQ(bench_complaint(spin, planted_motion(spin, stays)), "the body has turned by 0 rad, not by 3.3");
  const Vec3 axis = spin.setup.angular_velocity.normalized(), middle = Vec3::Constant(0.25);
  const auto turns = [&](double share) {
    return planted_motion(spin, [&, share](const Vec3& x, double t) -> Vec3 {
      return middle + Eigen::AngleAxisd(share * 10 * t, axis) * (x - middle);
    });
  };
  EXPECT_EQ(bench_complaint(spin, turns(1)), "");
  EXPECT_NE(bench_complaint(spin, turns(0.8)), "");
  EXPECT_EQ(bench_complaint(
                slope,
                planted_motion(slope, [](const Vec3& x, double t) -> Vec3 { return x + Vec3(t * t, 0, 0); })),
            "the block has not stayed where it was");
  EXPECT_EQ(
      bench_complaint(
          slope, planted_motion(slope, [](const Vec3& x, double t) -> Vec3 { return x + Vec3(0, 0, t); })),
      "the block has left the ground");
}

/// Of a ball whose ground is too far away nothing can be said.
TEST(BenchScenes, AFallWithoutGroundIsToldOfIt) {
  const BenchBody ball = small_bench("ball");
  FramePositions one{ball.start.x};  // after a frame
  for (const std::ptrdiff_t site : ball.body.sites())
    one.back().set(site, ball.start.x.at(site) - 0.005 * Vec3::UnitZ());
  EXPECT_EQ(bench_complaint(ball, one), "the body has not touched the ground");
}

TEST(BenchScenes, TheViscosityOfARatioDampsEdgesAsItDoes) {
  const BenchScene& scene = find_bench_scene("held_box");
  const double young = 1e6, ratio = 0.3;
  const auto edge_damping = [&](const Damping& damping, int cells) {
    const BenchBody body(scene, cells, {young, damping});
    double largest = 0;
    body.body.for_each_spring([&](auto, auto, const SpringSlot& slot, double, double c) {
      if (slot.kind == SpringSlot::Class::edge) largest = std::max(largest, c);
    });
    return largest;
  };
  const Damping viscosity = viscosity_like_ratio(ratio, young, 1.0 / 4);
  EXPECT_NEAR(edge_damping(viscosity, 4) / edge_damping(damping_of_ratio(ratio), 4), 1, 1e-12);
  // In cells half as large c = k eta / mu is half as large, the ratio's a quarter.
  EXPECT_NEAR(edge_damping(viscosity, 8) / edge_damping(viscosity, 4), 0.5, 1e-12);
}

TEST(MotionBounds, StableMeansWithinWhatTheSceneSupplies) {
  const MotionExtremes truth{.first_energy = 2, .energy = 3, .work = 2, .displacement = 0.1};
  EXPECT_EQ(supplied_energy(truth), 4);
  MotionExtremes run{.first_energy = 2, .energy = 5.9, .displacement = 0.149, .depth = 0.009};
  EXPECT_EQ(out_of_bounds(run, truth, 0.1), "");
  run.min_jacobian = -0.1;
  EXPECT_EQ(out_of_bounds(run, truth, 0.1), "folded");
  MotionExtremes folding = truth;
  folding.min_jacobian = -0.2;
  EXPECT_EQ(out_of_bounds(run, folding, 0.1), "");  // the true motion does so too
  run.depth = 0.011;
  EXPECT_EQ(out_of_bounds(run, truth, 0.1), "behind a plane");
  run.displacement = 0.151;
  EXPECT_EQ(out_of_bounds(run, truth, 0.1), "displacement");
  run.energy = 6.1;
  EXPECT_EQ(out_of_bounds(run, truth, 0.1), "energy");
  run.energy = std::nan("");
  EXPECT_EQ(out_of_bounds(run, truth, 0.1), "energy");
}

/// Frames are looked at while no time is taken, and a motion's energy is that which its scene supplies.
TEST(MotionBounds, OfAFreeFallAreInClosedForm) {
  const BenchBody ball = small_bench("ball");
  MotionWatch watch(ball);
  State<double> state = ball.start;
  constexpr double fallen = 0.3;
  for (const std::ptrdiff_t site : ball.body.sites()) {
    state.x.set(site, state.x.at(site) - fallen * Vec3::UnitZ());
    state.v.set(site, Vec3(0, 0, -std::sqrt(1.5 * 1.5 + 2 * 9.81 * fallen)));
  }
  watch.add(state);
  const MotionExtremes& e = watch.extremes();
  const double mass = ball.body.total_mass();
  EXPECT_NEAR(e.first_energy, mass / 2 * 1.5 * 1.5, 1e-9 * mass);
  EXPECT_NEAR(e.work, mass * 9.81 * fallen, 1e-9 * mass);
  EXPECT_NEAR(e.energy, e.first_energy + e.work, 1e-9 * mass);
  EXPECT_NEAR(e.displacement, fallen, 1e-12);
  EXPECT_NEAR(e.depth, fallen - 0.01, 1e-9);
}

}  // namespace
}  // namespace mss
