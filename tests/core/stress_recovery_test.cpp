// Stress of cells from their own forces, its gradient, and the energy of what a cell does not resolve.
#include "core/stress_recovery.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numeric>

#include "core/error.hpp"
#include "core/spring_system.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

constexpr double young = 2e5, poisson = 0.3;

BodyConfig bar(int nx, int ny, int nz, double h, double face_share = 0.5) {
  BodyConfig config{.voxels = VoxelGrid::box(nx, ny, nz), .cell_size = h, .origin = {0.3, -0.2, 0.1}};
  config.fill({young, poisson}, face_share);
  return config;
}

Field<double> field(const Body& body, const std::function<Vec3(const Vec3&)>& of_rest) {
  Field<double> all(body.lattice().size);
  for (const std::ptrdiff_t site : body.sites()) all.set(site, of_rest(body.rest_position(site)));
  return all;
}
Field<double> at_rest(const Body& body) {
  return field(body, [](const Vec3& x) { return x; });
}

double sum_of(const std::vector<double>& numbers) {
  return std::accumulate(numbers.begin(), numbers.end(), 0.0);
}

/// Stress of an isotropic solid under a small displacement gradient.
Eigen::Matrix3d hooke(const Eigen::Matrix3d& gradient) {
  const double mu = young / (2 * (1 + poisson)),
               lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  const Eigen::Matrix3d strain = (gradient + gradient.transpose()) / 2;
  return 2 * mu * strain + lambda * strain.trace() * Eigen::Matrix3d::Identity();
}

/// In pure bending about z by a curvature, sigma_xx = -E curvature (y - middle).
Field<double> bent(const Body& body, double curvature, double middle) {
  return field(body, [=](const Vec3& rest) -> Vec3 {
    const double x = rest[0], y = rest[1] - middle, z = rest[2];
    return curvature * Vec3(-x * y, (x * x + poisson * (y * y - z * z)) / 2, poisson * y * z);
  });
}

TEST(StressRecovery, UniformStrainHasHookesStressAndNoError) {
  Eigen::Matrix3d gradient;
  gradient << 2, 1, -3, 0.5, -1, 2, 4, 1, 3;
  for (const double face_share : {0.25, 1.0})
    for (const auto& shape : testing::test_shapes()) {
      BodyConfig config = bar(1, 1, 1, 0.2, face_share);
      config.voxels = shape.voxels;
      const Body body(config);
      const StressRecovery recovery(body);
      const Field<double> u = field(body, [&](const Vec3& x) -> Vec3 { return gradient * x; });
      const CellStress stress = recovery.stress_change(at_rest(body), u);
      const Eigen::Matrix3d expected = hooke(gradient);
      for (const Eigen::Matrix3d& s : stress) EXPECT_LT((s - expected).norm(), 1e-9 * expected.norm());
      const CellStressGradient g = recovery.gradient(stress);
      const double scale = expected.squaredNorm() / young * body.volume();
      EXPECT_NEAR(sum_of(recovery.error_products(g, g)) / scale, 0, 1e-18) << shape.name;
    }
}

// Of E curvature^2 h^5 / 12 in every cell; the ends' anticlastic displacements are quadratic too.
TEST(StressRecovery, PureBendingHasTheEnergyOfALinearStress) {
  constexpr double h = 0.25, curvature = 0.01;
  for (const double face_share : {0.5, 1.0}) {
    const Body body(bar(6, 4, 3, h, face_share));
    const StressRecovery recovery(body);
    const CellStress stress = recovery.stress_change(at_rest(body), bent(body, curvature, 0.3));
    for (std::size_t cell = 0; cell < stress.size(); ++cell) {
      Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
      expected(0, 0) = -young * curvature * (body.rest_position(recovery.cells()[cell])[1] + h / 2 - 0.3);
      EXPECT_LT((stress[cell] - expected).norm(), 1e-9 * young * curvature);
    }
    const CellStressGradient g = recovery.gradient(stress);
    const double expected = young * curvature * curvature * std::pow(h, 5) / 12;
    for (const double energy : recovery.error_products(g, g)) EXPECT_NEAR(energy, expected, 1e-9 * expected);
  }
}

// Half the work of springs at a cell's surface, where the strain is its gradient times h/2: four edges along
// x and four along z, and the diagonals of the two faces between them.
TEST(StressRecovery, SpringsOfABentCellStoreMoreThanAContinuum) {
  constexpr double h = 0.25, curvature = 0.01, mu = young / (2 * (1 + poisson));
  for (const double face_share : {0.25, 1.0}) {
    const Body body(bar(6, 4, 3, h, face_share));
    const StressRecovery recovery(body);
    const std::vector<SpringStrain> strains =
        recovery.spring_strain_change(at_rest(body), bent(body, curvature, 0.3));
    const double expected =
        mu * curvature * curvature * std::pow(h, 5) / 4 *
        ((2 - face_share) * (1 + poisson * poisson) + face_share * (1 - poisson) * (1 - poisson));
    for (const double energy : recovery.uneven_products(strains, strains))
      EXPECT_NEAR(energy, expected, 1e-9 * expected);
  }
}

TEST(StressRecovery, SpringStrainsAreGreensAndTheirChangeIsTheDerivative) {
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 2, 2));
  testing::fill_randomly(config, 3);
  const Body body(config);
  const StressRecovery recovery(body);
  Eigen::Matrix3d f;
  f << 1.2, 0.1, -0.05, 0.2, 0.9, 0.15, -0.1, 0.05, 1.1;
  for (const auto& [own, mean] : recovery.spring_strains(field(body, [&](const Vec3& x) { return f * x; })))
    EXPECT_NEAR(own, mean, 1e-12);  // an even deformation
  SpringSystem<double> system(body, {});
  State<double> state = system.rest_state(), other = state;
  testing::randomise(body, state, 0.2, 0, 6);
  testing::randomise(body, other, 0.5, 0, 7);
  Field<double> move = other.x, forth = state.x, back = state.x;
  move.array() -= state.x.array();
  constexpr double step = 1e-5;
  forth.array() += step * move.array();
  back.array() -= step * move.array();
  const auto change = recovery.spring_strain_change(state.x, move), a = recovery.spring_strains(forth),
             b = recovery.spring_strains(back);
  for (std::size_t s = 0; s < change.size(); ++s) {
    EXPECT_NEAR(change[s].own, (a[s].own - b[s].own) / (2 * step), 1e-8);
    EXPECT_NEAR(change[s].mean, (a[s].mean - b[s].mean) / (2 * step), 1e-8);
  }
}

TEST(StressRecovery, AxesAndComponentsAreThoseOfTheEnergy) {
  // u = (a x y, 0, b y z): every stress linear, in shear and pull, along two axes.
  constexpr double h = 0.5, a = 0.02, b = -0.01;
  const double mu = young / (2 * (1 + poisson)),
               lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  const Body body(bar(4, 4, 4, h));
  const StressRecovery recovery(body);
  const Field<double> u = field(body, [&](const Vec3& x) -> Vec3 {
    return {a * x[0] * x[1], 0, b * x[1] * x[2]};
  });
  const CellStressGradient g = recovery.gradient(recovery.stress_change(at_rest(body), u));
  // By x: strain 2 e_xy = a; by y: e_xx = a, e_zz = b; by z: 2 e_yz = b.
  const double along = 2 * mu * (a * a + b * b) + lambda * (a + b) * (a + b);
  const double expected = std::pow(h, 5) / 12 * (mu * a * a + along + mu * b * b);
  for (const double energy : recovery.error_products(g, g)) EXPECT_NEAR(energy, expected, 1e-9 * expected);
}

TEST(StressRecovery, IsTheCellsVirialAtSmallStrainsAndItsRotationBackAtLarge) {
  const Body body(testing::test_config(VoxelGrid::box(1, 1, 1)));
  SpringSystem<double> system(body, {.gravity = Vec3::Zero()});
  State<double> state = system.rest_state();
  Field<double> force(system.size());
  Eigen::Matrix3d kirchhoff = Eigen::Matrix3d::Zero();  // sum f x^T = F S F^T V0 where F is uniform
  Eigen::Matrix3d deformation;
  deformation << 1.2, 0.1, -0.05, 0.2, 0.9, 0.15, -0.1, 0.05, 1.1;
  for (const std::ptrdiff_t site : body.sites()) state.x.set(site, deformation * body.rest_position(site));
  system.force(0, state.x, state.v, force);
  for (const std::ptrdiff_t site : body.sites())
    kirchhoff -= force.at(site) * state.x.at(site).transpose() / body.cell_volume();
  const Eigen::Matrix3d s = StressRecovery(body).stress(state.x)[0];
  EXPECT_LT((deformation * s * deformation.transpose() - kirchhoff).norm(), 1e-12 * kirchhoff.norm());
}

TEST(StressRecovery, StaysAsItIsWhenTheBodyRotates) {
  const Body body(testing::test_config(VoxelGrid::box(3, 4, 5)));
  const StressRecovery recovery(body);
  SpringSystem<double> system(body, {});
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.2, 0, 6);
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(2.1, Vec3(1, 2, -1).normalized()) * Eigen::AngleAxisd(0.7, Vec3::UnitZ()))
          .toRotationMatrix();
  Field<double> turned = state.x;
  for (const std::ptrdiff_t site : body.sites()) turned.set(site, turn * state.x.at(site) + Vec3(1, 2, 3));
  const CellStress before = recovery.stress(state.x), after = recovery.stress(turned);
  const CellStressGradient g = recovery.gradient(before), turned_g = recovery.gradient(after);
  const std::vector<double> energy = recovery.error_products(g, g);
  const std::vector<double> turned_energy = recovery.error_products(turned_g, turned_g);
  for (std::size_t cell = 0; cell < energy.size(); ++cell)
    EXPECT_NEAR(turned_energy[cell], energy[cell], 1e-10 * energy[cell]);
}

TEST(StressRecovery, ItsChangeIsTheDerivative) {
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 2, 2));
  testing::add_parts(config);
  testing::fill_randomly(config, 3);
  const Body body(config);
  const StressRecovery recovery(body);
  SpringSystem<double> system(body, {});
  State<double> state = system.rest_state(), other = state;
  testing::randomise(body, state, 0.2, 0, 6);
  testing::randomise(body, other, 0.5, 0, 7);
  Field<double> move = other.x, forth = state.x, back = state.x;
  move.array() -= state.x.array();
  constexpr double step = 1e-5;
  forth.array() += step * move.array();
  back.array() -= step * move.array();
  const CellStress change = recovery.stress_change(state.x, move), a = recovery.stress(forth),
                   b = recovery.stress(back);
  for (std::size_t cell = 0; cell < change.size(); ++cell)
    EXPECT_LT((change[cell] - (a[cell] - b[cell]) / (2 * step)).norm(), 1e-6 * change[cell].norm());
}

// What is filled of a cell has the stress of a full one, and its share of the energy.
TEST(StressRecovery, OfAPartlyFilledCellIsThatOfWhatIsFilled) {
  constexpr double h = 0.25, curvature = 0.01;
  BodyConfig config = bar(5, 4, 3, h);
  testing::fill_evenly(config, std::vector<float>(60, 0.375F));
  const Body body(config);
  const StressRecovery recovery(body);
  const CellStressGradient g =
      recovery.gradient(recovery.stress_change(at_rest(body), bent(body, curvature, 0.3)));
  EXPECT_TRUE(recovery.has_partial_cells());
  const double expected = 0.375 * young * curvature * curvature * std::pow(h, 5) / 12;
  for (const double energy : recovery.error_products(g, g)) EXPECT_NEAR(energy, expected, 1e-9 * expected);
}

// Uniform strain in two materials: the stress jumps between them, and nothing is unresolved.
TEST(StressRecovery, AJumpBetweenPartsIsNoGradient) {
  BodyConfig config = bar(4, 3, 3, 0.25);
  config.contents = {{PartFill{}}, {{1, CellFill::even(1)}}};
  for (int cell = 0; cell < 36; ++cell) config.content_of.push_back(cell % 4 < 2 ? 0 : 1);
  Part hard{.name = "hard"};
  hard.springs = calibrate({10 * young, poisson}, 0.25, 0.5);
  config.parts = {hard};
  const Body body(config);
  const StressRecovery recovery(body);
  EXPECT_FALSE(recovery.has_partial_cells());
  const Field<double> u = field(body, [](const Vec3& x) -> Vec3 { return {x[0] + x[1], 0, 2 * x[2]}; });
  const CellStress stress = recovery.stress_change(at_rest(body), u);
  EXPECT_NEAR(stress[2](0, 0) / stress[1](0, 0), 10, 1e-9);
  const CellStressGradient g = recovery.gradient(stress);
  EXPECT_NEAR(sum_of(recovery.error_products(g, g)), 0, 1e-18 * young * body.volume());
}

double share_alone(const BodyConfig& config) {
  const Body body(config);
  return StressRecovery(body).share_alone();
}

TEST(StressRecovery, CountsCellsThatHaveNoNeighbourAlongAnAxis) {
  EXPECT_EQ(share_alone(bar(4, 3, 2, 1)), 0);
  EXPECT_EQ(share_alone(bar(4, 3, 1, 1)), 1);
  BodyConfig plate_with_block = bar(4, 2, 2, 1);
  for (const int i : {2, 3})
    for (const int j : {0, 1}) plate_with_block.voxels.set(i, j, 1, false);
  EXPECT_DOUBLE_EQ(share_alone(plate_with_block), 4.0 / 12);
}

TEST(StressRecovery, RefusesWhatHasNoElasticityOfItsCells) {
  BodyConfig uniform = bar(2, 2, 2, 0.5), diagonal = uniform, loose = uniform;
  uniform.sharing = Sharing::uniform;
  diagonal.topology = Topology::one_diagonal;
  loose.springs = {.edge = 1, .face = 0, .body = 0, .volume = 0};
  for (const BodyConfig& config : {uniform, diagonal, loose}) {
    const Body body(config);
    EXPECT_THROW(StressRecovery{body}, InputError);
  }
}

TEST(DoerflerMarking, TakesTheFewestThatReachTheShare) {
  const std::vector<double> indicators{1, 4, 0, 2, 3};
  using Ids = std::vector<std::size_t>;
  EXPECT_EQ(doerfler_marking(indicators, 0.4), Ids({1}));
  EXPECT_EQ(doerfler_marking(indicators, 0.41), Ids({1, 4}));
  EXPECT_EQ(doerfler_marking(indicators, 0.7), Ids({1, 4}));
  EXPECT_EQ(doerfler_marking(indicators, 0.9), Ids({1, 4, 3}));
  EXPECT_EQ(doerfler_marking(indicators, 1), Ids({1, 4, 3, 0}));
  EXPECT_EQ(doerfler_marking({2, 2, 2}, 0.5), Ids({0, 1}));
  EXPECT_TRUE(doerfler_marking({0, 0}, 0.5).empty());
  EXPECT_TRUE(doerfler_marking({}, 0.5).empty());
}

}  // namespace
}  // namespace mss
