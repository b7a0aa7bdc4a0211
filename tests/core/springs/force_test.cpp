// Forces of the structured sweep against Algorithm 1, for every shape, topology, sharing, damping law and
// kernel.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "core/kernels/sweep.hpp"
#include "tests/force_oracle.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

template <class Real>
void check_all_forces(double tolerance) {
  int checked = 0;
  for (const auto& shape : testing::test_shapes())
    for (const auto topology : {Topology::full, Topology::edges_body, Topology::one_diagonal})
      for (const auto sharing : {Sharing::weighted, Sharing::uniform})
        for (const auto law :
             {Damping::Law::none, Damping::Law::ratio, Damping::Law::thesis, Damping::Law::viscosity})
          for (const auto& kernel : runnable_copies<SweepKernel<Real>>())
            for (const int threads : {1, 2}) {
              BodyConfig config = testing::test_config(shape.voxels);
              config.topology = topology;
              config.sharing = sharing;
              config.damping.law = law;
              config.damping.viscosity = 20;
              EXPECT_LT(testing::relative_force_error<Real>(config, kernel.name, threads), tolerance)
                  << shape.name << " topology " << int(topology) << " sharing " << int(sharing) << " damping "
                  << int(law) << " kernel " << kernel.name << " threads " << threads;
              ++checked;
            }
  EXPECT_EQ(checked, 10 * 3 * 2 * 4 * 2 * int(runnable_copies<SweepKernel<Real>>().size()));
}

TEST(Force, EqualsOracleInDouble) { check_all_forces<double>(1e-12); }
TEST(Force, EqualsOracleInSingle) { check_all_forces<float>(1e-5); }

/// Springs strained by 1e-6 pull with a difference of two lengths: an error of 1e-14 of a length is one of
/// 1e-8 of the force.
TEST(Force, EqualsOracleNearRest) {
  for (const auto& shape : testing::test_shapes())
    for (const auto& kernel : runnable_copies<SweepKernel<double>>()) {
      BodyConfig config = testing::test_config(shape.voxels);
      config.damping.law = Damping::Law::none;
      EXPECT_LT(testing::relative_force_error<double>(config, kernel.name, 1, 1e-6, Vec3::Zero()), 2e-9)
          << shape.name << " kernel " << kernel.name;
    }
}

/// With the guard against folding, which acts on few corners at the smallest of these amplitudes and on most
/// at the largest; with all other contents of a cell, each of which has a sweep of its own.
template <class Real>
void check_guarded_forces(double tolerance) {
  struct Content {
    Topology topology;
    double body, volume;
  };
  constexpr std::array contents{Content{Topology::full, 250, 700}, Content{Topology::full, 250, 0},
                                Content{Topology::full, 0, 700}, Content{Topology::full, 0, 0},
                                Content{Topology::edges_body, 250, 700}};
  int checked = 0;
  for (const auto& shape : testing::test_shapes())
    for (const double amplitude : {0.2, 0.35, 0.7})
      for (const Content& content : contents)
        for (const auto& kernel : runnable_copies<SweepKernel<Real>>()) {
          BodyConfig config = testing::test_config(shape.voxels);
          config.damping.law = amplitude < 0.5 ? Damping::Law::none : Damping::Law::ratio;
          config.topology = content.topology;
          config.springs.body = content.body;
          config.springs.volume = content.volume;
          const double without = testing::relative_force_error<Real>(config, kernel.name, 1, amplitude);
          config.fold_guard = 10;
          EXPECT_LT(without, tolerance);
          EXPECT_LT(testing::relative_force_error<Real>(config, kernel.name, 2, amplitude), tolerance)
              << shape.name << " amplitude " << amplitude << " kernel " << kernel.name;
          ++checked;
        }
  EXPECT_EQ(checked, 10 * 3 * 5 * int(runnable_copies<SweepKernel<Real>>().size()));
}

TEST(Force, OfTheFoldGuardEqualsOracleInDouble) { check_guarded_forces<double>(1e-12); }
TEST(Force, OfTheFoldGuardEqualsOracleInSingle) { check_guarded_forces<float>(1e-5); }

// Its sweep checks a bound on a whole cell: no corner of a hardly strained cell may be missed.
TEST(Force, OfTheFoldGuardActsOnASingleCorner) {
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 2, 2));
  BodyConfig guarded_config = config;
  guarded_config.fold_guard = 10;
  const Body body(config), guarded_body(guarded_config);
  SpringSystem<double> plain(body, {}, {.threads = 1}), guarded(guarded_body, {}, {.threads = 1});
  std::mt19937_64 random(4);
  std::uniform_real_distribution<> share(-1, 1);
  int acting = 0;
  for (unsigned trial = 0; trial < 2000; ++trial) {
    State<double> state = plain.rest_state();
    testing::randomise(body, state, 0.05, 0, trial);
    const std::ptrdiff_t moved = body.sites()[trial % body.particle_count()];
    const Vec3 by(share(random), share(random), share(random));
    state.x.set(moved, state.x.at(moved) + 0.6 * config.cell_size * by);
    reference::Algorithm1 oracle(guarded_config, Vec3::Zero(), 1), unguarded(config, Vec3::Zero(), 1);
    for (reference::Algorithm1* each : {&oracle, &unguarded}) {
      testing::copy_state(body, state, *each);
      each->compute_forces();
    }
    Field<double> f(plain.size()), g(plain.size());
    plain.force(0, state.x, state.v, f);
    guarded.force(0, state.x, state.v, g);
    double error = 0, largest = 0, all = 0;
    for (std::size_t id = 0; id < body.particle_count(); ++id) {
      all = std::max(all, oracle.particles()[id].f.norm());
      const Vec3 expected = oracle.particles()[id].f - unguarded.particles()[id].f;
      error = std::max(error, (g.at(body.sites()[id]) - f.at(body.sites()[id]) - expected).norm());
      largest = std::max(largest, expected.norm());
    }
    if (largest > 0) ++acting;
    EXPECT_LT(error, 1e-12 * all) << trial;
  }
  EXPECT_GT(acting, 200);
  EXPECT_LT(acting, 1800);
}

// It is not a small force where it acts, and changes no bit elsewhere.
TEST(Force, OfTheFoldGuardActsNearFoldingOnly) {
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 3, 3));
  BodyConfig guarded_config = config;
  guarded_config.fold_guard = 5;
  const Body body(config), guarded_body(guarded_config);
  SpringSystem<double> plain(body, {}, {.threads = 1}), guarded(guarded_body, {}, {.threads = 1});
  for (const double amplitude : {0.05, 0.7}) {
    State<double> state = plain.rest_state();
    testing::randomise(body, state, amplitude, 0.5, 3);
    Field<double> f(plain.size()), g(plain.size());
    plain.force(0, state.x, state.v, f);
    guarded.force(0, state.x, state.v, g);
    const double difference = (f.array() - g.array()).abs().maxCoeff();
    if (amplitude < 0.1)
      EXPECT_EQ(difference, 0);
    else
      EXPECT_GT(difference, 0.2 * f.array().abs().maxCoeff());
  }
}

}  // namespace
}  // namespace mss
