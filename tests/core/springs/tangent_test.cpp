// Tangents against central differences of the force, the matrix-free product against the matrix, and the
// projected form: no negative eigenvalue in any state.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/kernels/sweep.hpp"
#include "core/springs/element_tangents.hpp"
#include "core/springs/spring_system.hpp"
#include "tests/dense_eigenvalues.hpp"
#include "tests/differences.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

using Dense = Eigen::MatrixXd;
using testing::relative_difference;

/// A body in a random state. Amplitudes beyond half a cell fold cells and invert some.
struct TangentScenario {
  Body body;
  SpringSystem<double> system;
  State<double> state;
  TangentScenario(const BodyConfig& config, double amplitude, unsigned seed,
                  const Environment& environment = {})
      : body(config), system(body, environment), state(system.rest_state()) {
    testing::randomise(body, state, amplitude, 0.5, seed);
  }
  Dense tangent(const TangentCoefficients& sum) {
    SparseMatrix matrix = system.tangents()->pattern();
    system.tangents()->values(0, state.x, state.v, sum, matrix);
    return matrix;
  }
  Dense differences(bool of_positions) {
    return testing::force_differences(system, state, of_positions, body.config().cell_size);
  }
};

std::vector<BodyConfig> small_configs() {
  std::vector<BodyConfig> configs;
  for (const auto& shape : testing::test_shapes()) {
    if (shape.voxels.count() > 40) continue;
    for (const auto topology : {Topology::full, Topology::edges_body, Topology::one_diagonal})
      for (const double volume : {700.0, 0.0, -90.0}) {
        configs.push_back(testing::test_config(shape.voxels));
        configs.back().topology = topology;
        configs.back().springs.volume = volume;
        configs.back().fold_guard = volume > 0 ? 5 : 0;
      }
  }
  EXPECT_GE(configs.size(), 3U * 3U);
  return configs;
}

TEST(Tangent, EqualsDifferencesOfTheForce) {
  for (const BodyConfig& config : small_configs()) {
    TangentScenario s(config, config.fold_guard > 0 ? 0.5 : 0.3, 5);
    EXPECT_LT(relative_difference(s.tangent({.stiffness = 1, .kind = Tangent::exact}), s.differences(true)),
              1e-6);
    EXPECT_LT(relative_difference(s.tangent({.damping = 1, .kind = Tangent::exact}), s.differences(false)),
              1e-6);
  }
}

TEST(Tangent, LeavesOutWhatIsPrescribed) {
  const BodyConfig config = testing::test_config(VoxelGrid::box(2, 1, 2));
  const Vec3 low = config.origin;
  Environment environment;
  environment.holds.resize(2);
  environment.holds[0].box = {low, low + Vec3(0, 1, 1)};
  environment.holds[1].box = {low, low + Vec3(1, 1, 0)};
  environment.holds[1].axes = {false, true, false};
  TangentScenario s(config, 0.3, 5, environment);
  EXPECT_EQ(s.system.tangents()->unknowns().size(), 3U * 18 - 3 * 6 - 4);
  EXPECT_LT(relative_difference(s.tangent({.stiffness = 1, .kind = Tangent::exact}), s.differences(true)),
            1e-6);
}

TEST(Tangent, IsTheRequestedSum) {
  TangentScenario s(testing::test_config(VoxelGrid::box(2, 2, 1)), 0.3, 5);
  const Dense m = s.tangent({.mass = 1}), c = s.tangent({.damping = 1}), k = s.tangent({.stiffness = 1});
  EXPECT_LT(
      relative_difference(s.tangent({.mass = 2, .damping = 0.3, .stiffness = 5}), 2 * m + 0.3 * c + 5 * k),
      1e-14);
  EXPECT_EQ((m - Dense(m.diagonal().asDiagonal())).norm(), 0);
  EXPECT_NEAR(m.trace(), 3 * s.body.total_mass(), 1e-12 * s.body.total_mass());
}

TEST(Tangent, IsSymmetricWhereThePhysicsIs) {
  TangentScenario s(testing::test_config(VoxelGrid::box(2, 2, 2)), 0.3, 5);
  const Dense elastic = s.tangent({.stiffness = 1, .kind = Tangent::elastic});
  EXPECT_LT((elastic - elastic.transpose()).norm(), 1e-14 * elastic.norm());
  const Dense exact = s.tangent({.stiffness = 1, .kind = Tangent::exact});
  EXPECT_GT((exact - exact.transpose()).norm(), 1e-3 * exact.norm());  // damped springs rotate
  BodyConfig undamped = s.body.config();
  undamped.damping.law = Damping::Law::none;
  TangentScenario u(undamped, 0.3, 5);
  EXPECT_EQ((u.tangent({.stiffness = 1, .kind = Tangent::exact}) - elastic).norm(), 0);
}

TEST(Tangent, ProjectedIsPositiveSemidefiniteInAnyState) {
  BodyConfig config = testing::test_config(VoxelGrid::box(2, 1, 2));
  int checked = 0, indefinite = 0;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    config.springs.volume = seed % 3 == 0 ? -50 : 700;
    config.fold_guard = seed % 2 == 0 ? 0 : 5;
    TangentScenario s(config, 0.05 + 2.5 * seed / 1000, seed);
    if (seed % 5 == 0)  // pressed flat, or squeezed to a tenth
      for (const auto site : s.body.sites())
        s.state.x.set(
            site, s.state.x.at(site).cwiseProduct(seed % 2 == 0 ? Vec3(1, 1, 0.01) : Vec3(0.1, 0.1, 0.1)));
    const auto smallest = [&](Tangent kind) {
      const Dense k = s.tangent({.stiffness = 1, .kind = kind});
      const Eigen::VectorXd eigenvalues = testing::symmetric_eigenvalues(k);
      return eigenvalues[0] / eigenvalues[eigenvalues.size() - 1];
    };
    EXPECT_GT(smallest(Tangent::projected), -1e-12) << seed;
    if (smallest(Tangent::elastic) < -1e-3) ++indefinite;
    ++checked;
  }
  EXPECT_EQ(checked, 1000);
  EXPECT_GT(indefinite, 500);  // the projection changed something
}

template <class Real>
void compare_products(double tolerance) {
  int checked = 0;
  for (const auto& shape : testing::test_shapes())
    for (const auto topology : {Topology::full, Topology::edges_body, Topology::one_diagonal})
      for (const auto kind : {Tangent::elastic, Tangent::projected})
        for (const auto& kernel : runnable_copies<SweepKernel<Real>>())
          for (const int threads : {1, 3}) {
            BodyConfig config = testing::test_config(shape.voxels);
            config.topology = topology;
            config.fold_guard = threads == 3 ? 5 : 0;
            const Body body(config);
            SpringSystem<Real> system(body, {.gravity = Vec3(1, 2, 3)}, {threads, kernel.name});
            State<Real> state = system.rest_state(), direction = system.rest_state();
            testing::randomise(body, state, threads == 3 ? 0.6 : 0.4, 0.5, 8);
            testing::randomise(body, direction, 1, 1, 9);
            const TangentCoefficients sum{.mass = 40, .damping = 0.7, .stiffness = 1.3, .kind = kind};
            Field<Real> out(system.size());
            system.tangents()->product(0, state.x, state.v, sum, direction.v, out);
            SparseMatrix matrix = system.tangents()->pattern();
            system.tangents()->values(0, state.x, state.v, sum, matrix);
            Eigen::VectorXd p(matrix.rows()), product(matrix.rows());
            for (Eigen::Index i = 0; i < p.size(); ++i) {
              const auto [site, axis] = system.tangents()->unknowns()[std::size_t(i)];
              p[i] = double(direction.v.axis(axis)[site]);
              product[i] = double(out.axis(axis)[site]);
            }
            const Eigen::VectorXd expected = matrix * p;
            EXPECT_LT((product - expected).norm(), tolerance * expected.norm())
                << shape.name << " " << kernel.name;
            ++checked;
          }
  EXPECT_EQ(checked, 10 * 3 * 2 * 2 * int(runnable_copies<SweepKernel<Real>>().size()));
}
TEST(Tangent, ProductEqualsTheMatrixInDouble) { compare_products<double>(1e-13); }
TEST(Tangent, ProductEqualsTheMatrixInSingle) { compare_products<float>(1e-5); }

template <class Real>
void compare_diagonals(double tolerance) {
  for (const auto& shape : testing::test_shapes())
    for (const double guard : {0.0, 5.0})
      for (const auto& kernel : runnable_copies<SweepKernel<Real>>()) {
        BodyConfig config = testing::test_config(shape.voxels);
        config.fold_guard = guard;
        const Body body(config);
        SpringSystem<Real> system(body, {}, {.threads = 2, .kernel = kernel.name});
        State<Real> state = system.rest_state();
        testing::randomise(body, state, guard > 0 ? 0.6 : 0.3, 0.5, 5);
        for (const Tangent kind : {Tangent::elastic, Tangent::projected}) {
          const TangentCoefficients sum{.mass = 3, .damping = 0.2, .stiffness = 0.7, .kind = kind};
          SparseMatrix matrix = system.tangents()->pattern();
          system.tangents()->values(0, state.x, state.v, sum, matrix);
          std::vector<Eigen::Matrix3d> blocks;
          system.tangents()->diagonal(0, state.x, state.v, sum, blocks);
          ASSERT_EQ(blocks.size(), body.particle_count());
          const double allowed = tolerance * matrix.norm();
          for (int p = 0; p < int(blocks.size()); ++p)
            for (int a = 0; a < 3; ++a)
              for (int b = 0; b < 3; ++b)
                ASSERT_NEAR(blocks[std::size_t(p)](a, b), matrix.coeff(3 * p + a, 3 * p + b), allowed)
                    << shape.name << " " << kernel.name;
        }
      }
}
TEST(Tangent, DiagonalIsTheMatrixsInDouble) { compare_diagonals<double>(1e-13); }
TEST(Tangent, DiagonalIsTheMatrixsInSingle) { compare_diagonals<float>(1e-5); }

}  // namespace
}  // namespace mss
