// Numbers per particle against those of the whole body, and the effect of the user's pull on forces, tangents
// and momentum.
#include "core/measures/particle_measures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/environment/tethered_system.hpp"
#include "core/measures/measures.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "tests/differences.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

TEST(ParticleMeasures, ReachTheExtremesOfTheWholeBody) {
  int bodies = 0;
  for (const auto& shape : testing::test_shapes()) {
    const Body body(testing::test_config(shape.voxels));
    const SpringSystem<double> system(body, {});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0.3, 0, 11);
    double stretch = 0, jacobian = 1e9;
    for (const std::ptrdiff_t site : body.sites()) {
      stretch = std::max(stretch, stretch_at({body}, state.x, site));
      jacobian = std::min(jacobian, jacobian_at({body}, state.x, site));
    }
    const Measures whole = measure(system, state);
    EXPECT_EQ(stretch, whole.max_stretch) << shape.name;
    EXPECT_EQ(jacobian, whole.min_jacobian) << shape.name;
    ++bodies;
  }
  EXPECT_GE(bodies, 9);
}

TEST(ParticleMeasures, VolumeRatioOfAUniformStretch) {
  const Body body(testing::test_config(VoxelGrid::box(3, 2, 2)));
  Field<double> x(body.lattice().size);
  for (const std::ptrdiff_t site : body.sites())
    x.set(site, body.rest_position(site).cwiseProduct(Vec3(1.1, 0.9, 1.2)));
  for (const std::ptrdiff_t site : body.sites())
    EXPECT_NEAR(volume_ratio_at({body}, x, site), 1.1 * 0.9 * 1.2, 1e-12);
}

/// A small damped body in a random state, with a tether on a corner.
struct Tethered {
  Body body;
  SpringSystem<double> springs;
  TetheredSystem<double> system;
  State<double> state;
  Tether tether;

  explicit Tethered(const Environment& environment = {})
      : body(testing::test_config(VoxelGrid::box(2, 1, 2))),
        springs(body, environment),
        system(springs),
        state(springs.rest_state()),
        tether(stable_tether(body.mass(body.sites().back()), springs.spectral_bound(), body.sites().back())) {
    testing::randomise(body, state, 0.2, 0.5, 3);
    tether.anchor = state.x.at(tether.site) + Vec3(0.3, -0.2, 0.1);
  }
};

TEST(Tether, TangentsAreDifferencesOfTheForce) {
  Tethered t;
  t.system.tie(t.tether);
  const double h = t.body.config().cell_size;
  for (const bool of_positions : {true, false}) {
    TangentCoefficients sum{.kind = Tangent::exact};
    (of_positions ? sum.stiffness : sum.damping) = 1;
    SparseMatrix matrix = t.system.tangents()->pattern();
    t.system.tangents()->values(0, t.state.x, t.state.v, sum, matrix);
    EXPECT_LT(testing::relative_difference(Eigen::MatrixXd(matrix),
                                           testing::force_differences(t.system, t.state, of_positions, h)),
              1e-6);
  }
}

TEST(Tether, ProductAndDiagonalAreThoseOfTheMatrix) {
  Tethered t;
  t.system.tie(t.tether);
  const TangentCoefficients sum{.mass = 2, .damping = 0.3, .stiffness = 0.7, .kind = Tangent::elastic};
  SparseMatrix matrix = t.system.tangents()->pattern();
  t.system.tangents()->values(0, t.state.x, t.state.v, sum, matrix);
  Field<double> product(t.system.size());
  t.system.tangents()->product(0, t.state.x, t.state.v, sum, t.state.v, product);
  std::vector<Eigen::Matrix3d> blocks;
  t.system.tangents()->diagonal(0, t.state.x, t.state.v, sum, blocks);
  const auto& unknowns = t.system.tangents()->unknowns();
  Eigen::VectorXd v(unknowns.size());
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    v[Eigen::Index(i)] = t.state.v.axis(unknowns[i].axis)[unknowns[i].site];
  const Eigen::VectorXd expected = matrix * v;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto [site, axis] = unknowns[i];
    EXPECT_NEAR(product.axis(axis)[site], expected[Eigen::Index(i)], 1e-9 * expected.norm());
    EXPECT_NEAR(blocks[i / 3](axis, axis), matrix.coeff(int(i), int(i)), 1e-9 * expected.norm());
  }
}

TEST(Tether, ChangesMomentumByItsImpulseAlone) {
  Tethered t;
  t.system.tie(t.tether);
  const auto method = find_integrator("semi_implicit_euler").make<double>({.dt = 1e-4});
  const Vec3 before = measure(t.springs, t.state).momentum;
  Vec3 impulse = Vec3::Zero();
  Work work;
  for (int step = 1; step <= 200; ++step) {
    impulse += 1e-4 * t.tether.force(t.state.x.at(t.tether.site), t.state.v.at(t.tether.site));
    ASSERT_EQ(method->advance(t.system, t.state, step * 1e-4, work), Status::ok);
  }
  EXPECT_GT(impulse.norm(), 1e-3);
  EXPECT_LT((measure(t.springs, t.state).momentum - before - impulse).norm(), 1e-10 * impulse.norm());
}

TEST(Tether, HasNoEffectOnceReleased) {
  Tethered once, never;
  once.system.tie(once.tether);
  once.system.tie(std::nullopt);
  const KickDrift update{.kick_after = 1e-3, .drift_new = 1e-3};
  once.system.kick_drift(update, 1e-3, 5, once.state);
  never.springs.kick_drift(update, 1e-3, 5, never.state);
  EXPECT_TRUE((once.state.x.array() == never.state.x.array()).all());
  EXPECT_TRUE((once.state.v.array() == never.state.v.array()).all());
}

// At the bound itself the safe step leaves a margin of a tenth of dt: the tether must not use it up.
TEST(Tether, LeavesTheSafeStepSafe) {
  const Tethered t;
  const SpectralBound bound = t.springs.spectral_bound();
  const double mass = t.body.mass(t.tether.site);
  const double dt = safe_share * central_limit(bound.omega, bound.damping);
  const double pulled = std::sqrt(bound.omega * bound.omega + t.tether.stiffness / mass);
  EXPECT_LT(dt, central_limit(pulled, bound.damping + t.tether.damping / mass));
  EXPECT_NEAR(t.tether.stiffness / (mass * bound.omega * bound.omega), 0.05, 1e-12);
}

}  // namespace
}  // namespace mss
