// Mollemans's volume force: its agreement with eq. 3-7, its direction, and the momentum it does not conserve.
#include "reference/mollemans.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/base/error.hpp"
#include "core/measures/measures.hpp"
#include "tests/dense_eigenvalues.hpp"
#include "tests/differences.hpp"
#include "tests/driven.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

/// Volume forces alone.
BodyConfig volume_only(const VoxelGrid& voxels) {
  BodyConfig config = testing::test_config(voxels);
  config.springs = {.volume = 700};
  config.damping = {};
  return config;
}

State<double> mapped(const BodySystem<double>& system, const Eigen::Matrix3d& map) {
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : system.body().sites())
    state.x.set(site, map * system.body().rest_position(site));
  return state;
}

// Calibrated for an even stretch, the forces of both agree for any small map, particle by particle.
TEST(Mollemans, IsEquation_3_7_ToFirstOrderForAffineMaps) {
  for (const auto& shape : testing::test_shapes()) {
    const Body body(volume_only(shape.voxels));
    MollemansSystem tetrahedra(body, {});
    SpringSystem<double> cells(body, {}, {.threads = 1});
    double before = 0;
    for (const double size : {1e-3, 1e-4}) {
      Eigen::Matrix3d map;
      map << 0.9, 0.5, -0.3, 0.2, 0.7, 0.4, -0.6, 0.1, 0.8;
      const State<double> state = mapped(cells, Eigen::Matrix3d::Identity() + size * map);
      Field<double> a(cells.size()), b(cells.size());
      cells.force(0, state.x, state.v, a);
      tetrahedra.force(0, state.x, state.v, b);
      const double largest = a.array().abs().maxCoeff();
      const double difference = (a.array() - b.array()).abs().maxCoeff() / largest;
      EXPECT_LT(difference, 3 * size) << shape.name;
      if (before > 0) {
        EXPECT_NEAR(before / difference, 10, 0.5) << shape.name;  // of the order of the strain
      }
      before = difference;
    }
  }
}

TEST(Mollemans, RefusesCellsThatAreNotFull) {
  BodyConfig config = volume_only(VoxelGrid::box(2, 1, 1));
  testing::fill_evenly(config, {1, 0.5F});
  const Body body(config);
  EXPECT_THROW(MollemansSystem(body, {}), InputError);
}

TEST(Mollemans, PushesASwollenCellTogether) {
  const Body body(volume_only(VoxelGrid::box(1, 1, 1)));
  MollemansSystem system(body, {});
  for (const double stretch : {0.9, 1.1}) {
    const State<double> state = mapped(system, stretch * Eigen::Matrix3d::Identity());
    Field<double> f(system.size());
    system.force(0, state.x, state.v, f);
    double outward = 0;
    for (const std::ptrdiff_t site : body.sites()) outward += f.at(site).dot(state.x.at(site));
    EXPECT_LT(outward * (stretch - 1), 0);
  }
}

// Unit vectors from a barycentre add up to zero in a regular tetrahedron only.
TEST(Mollemans, DoesNotKeepMomentum) {
  const Body body(volume_only(VoxelGrid::box(2, 2, 2)));
  MollemansSystem system(body, {});
  SpringSystem<double> cells(body, {}, {.threads = 1});
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.2, 0, 3);
  const auto total = [&](BodySystem<double>& of) {
    Field<double> f(of.size());
    of.force(0, state.x, state.v, f);
    Vec3 sum = Vec3::Zero();
    for (const std::ptrdiff_t site : body.sites()) sum += f.at(site);
    return sum.norm() / f.array().abs().maxCoeff();
  };
  EXPECT_LT(total(cells), 1e-13);
  EXPECT_GT(total(system), 1e-3);
}

BodyConfig with_springs(const VoxelGrid& voxels) {
  BodyConfig config = testing::test_config(voxels);
  config.fill({.young = 1e4, .poisson = 0.4}, 0.5);
  return config;
}

TEST(Mollemans, TangentIsTheSlopeOfItsForce) {
  const Body body(with_springs(VoxelGrid::box(2, 1, 2)));
  MollemansSystem system(body, {});
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.15, 0.5, 11);
  SparseMatrix matrix = system.tangents()->pattern();
  for (const bool of_positions : {true, false}) {
    const TangentCoefficients sum{.damping = of_positions ? 0.0 : 1.0, .stiffness = of_positions ? 1.0 : 0.0};
    system.tangents()->values(0, state.x, state.v, sum, matrix);
    EXPECT_LT(testing::relative_difference(
                  matrix, testing::force_differences(system, state, of_positions, body.config().cell_size)),
              1e-7);
  }
}

TEST(Mollemans, ProductAndDiagonalAreTheTangents) {
  const Body body(with_springs(VoxelGrid::box(2, 2, 1)));
  MollemansSystem system(body, {}, 2);
  State<double> state = system.rest_state(), direction = system.rest_state();
  testing::randomise(body, state, 0.15, 0.5, 5);
  testing::randomise(body, direction, 1, 0, 6);
  for (const Tangent kind : {Tangent::elastic, Tangent::projected}) {
    const TangentCoefficients sum{.mass = 2, .damping = 0.3, .stiffness = 0.1, .kind = kind};
    SparseMatrix sparse = system.tangents()->pattern();
    system.tangents()->values(0, state.x, state.v, sum, sparse);
    const Eigen::MatrixXd matrix = sparse;
    EXPECT_LT((matrix - matrix.transpose()).norm(), 1e-13 * matrix.norm());
    Field<double> product(system.size());
    system.tangents()->product(0, state.x, state.v, sum, direction.x, product);
    std::vector<Eigen::Matrix3d> blocks;
    system.tangents()->diagonal(0, state.x, state.v, sum, blocks);
    Eigen::VectorXd p(matrix.rows()), q(matrix.rows());
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
      const auto [site, axis] = system.tangents()->unknowns()[std::size_t(i)];
      p[i] = direction.x.axis(axis)[site];
      q[i] = product.axis(axis)[site];
    }
    EXPECT_LT((matrix * p - q).norm(), 1e-12 * q.norm());
    ASSERT_EQ(3 * blocks.size(), std::size_t(matrix.rows()));
    for (std::size_t b = 0; b < blocks.size(); ++b)
      EXPECT_LT((blocks[b] - matrix.block<3, 3>(3 * Eigen::Index(b), 3 * Eigen::Index(b))).norm(),
                1e-12 * matrix.norm());
  }
}

TEST(Mollemans, BoundsItsFrequencies) {
  const Body body(with_springs(VoxelGrid::box(3, 2, 2)));
  MollemansSystem system(body, {});
  const State<double> rest = system.rest_state();
  SparseMatrix k = system.tangents()->pattern(), m = k;
  system.tangents()->values(0, rest.x, rest.v, {.stiffness = 1}, k);
  system.tangents()->values(0, rest.x, rest.v, {.mass = 1}, m);
  const double fastest = std::sqrt(testing::any_eigenvalues(k, m).real().maxCoeff());
  EXPECT_GE(system.spectral_bound().omega, fastest);
  EXPECT_LT(system.spectral_bound().omega, 1.5 * fastest);
}

TEST(Mollemans, IsDrivenByEveryIntegrator) {
  const Body body(with_springs(VoxelGrid::box(2, 2, 2)));
  const Vec3 low = body.config().origin;
  MollemansSystem system(body,
                         {.gravity = Vec3(0, 0, -9.81), .holds = {{.box = {low, low + Vec3(0.4, 0.4, 0)}}}});
  testing::expect_driven_by_every_integrator(system);
}

}  // namespace
}  // namespace mss
