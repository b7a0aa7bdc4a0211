// What a lattice's energy has more than a continuum's of the displacement recovered from it, and which cells
// that says to refine.
#include "core/refinement/displacement_recovery.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <functional>

#include "core/base/error.hpp"
#include "core/refinement/marking.hpp"
#include "core/springs/spring_system.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

constexpr double young = 2e5, poisson = 0.3, mu = young / (2 * (1 + poisson));
constexpr double h = 0.25, curvature = 0.01;
using Products = DisplacementRecovery::Products;

BodyConfig bar(int nx, int ny, int nz, double face_share = 0.5) {
  BodyConfig config{.voxels = VoxelGrid::box(nx, ny, nz), .cell_size = h, .origin = {0.3, -0.2, 0.1}};
  config.fill({young, poisson}, face_share);
  return config;
}

Field<double> field(const Body& body, const std::function<Vec3(const Vec3&)>& of_rest) {
  Field<double> all(body.lattice().size);
  for (const std::ptrdiff_t site : body.sites()) all.set(site, of_rest(body.rest_position(site)));
  return all;
}

/// Of a small displacement from rest with itself.
Products of_displacement(const Body& body, const std::function<Vec3(const Vec3&)>& u) {
  const Field<double> rest = field(body, [](const Vec3&x) { return x; }), moved = field(body, u);
  return DisplacementRecovery(body).products({rest, &moved}, {rest, &moved});
}

Vec3 affine(const Vec3& x) {
  return {2 * x[0] + x[1] - 3 * x[2], x[0] / 2 - x[1], 4 * x[0] + x[1] + 3 * x[2]};
}

/// Pure bending about z: sigma_xx = -E curvature (y - 0.3), all other stresses 0.
Vec3 bent(const Vec3& rest) {
  const double x = rest[0], y = rest[1] - 0.3, z = rest[2];
  return curvature * Vec3(-x * y, (x * x + poisson * (y * y - z * z)) / 2, poisson * y * z);
}

/// What a cell of springs in pure bending stores beyond the mean deformation: half the work of springs at its
/// surface, where the strain is its gradient times h/2: four edges along x and four along z, and the
/// diagonals of the two faces between them; beyond a continuum: less E curvature^2 h^5 / 12.
double beyond_a_bent_continuum(double face_share) {
  const double t = face_share, moment = curvature * curvature * std::pow(h, 5);
  return mu * moment / 4 * ((2 - t) * (1 + poisson * poisson) + t * (1 - poisson) * (1 - poisson)) -
         young * moment / 12;
}

TEST(DisplacementRecovery, AnEvenDeformationHasNoError) {
  for (const double face_share : {0.25, 1.0})
    for (const auto& shape : testing::test_shapes()) {
      BodyConfig config = bar(1, 1, 1, face_share);
      config.voxels = shape.voxels;
      const Body body(config);
      const Products products = of_displacement(body, affine);
      EXPECT_GT(products.stored, 1e3) << shape.name;
      for (const double error : products.error)
        EXPECT_NEAR(error * double(products.error.size()), 0, 1e-12 * products.stored) << shape.name;
    }
}

TEST(DisplacementRecovery, NorDoesALargeOne) {
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 2, 2));
  testing::fill_evenly(config, {1, 0.5, 1, 1, 0.25, 1, 1, 1, 1, 1, 0.75, 1});
  const Body body(config);
  Eigen::Matrix3d f;
  f << 1.2, 0.1, -0.05, 0.2, 0.9, 0.15, -0.1, 0.05, 1.1;
  const Field<double> x = field(body, [&](const Vec3& rest) -> Vec3 { return f * rest; });
  const Products products = DisplacementRecovery(body).products({x}, {x});
  for (const double error : products.error) EXPECT_NEAR(error, 0, 1e-13 * products.stored);
}

// Quadratic, so that it is recovered exactly in every cell.
TEST(DisplacementRecovery, PureBendingIsAnalytic) {
  for (const double face_share : {0.25, 0.5, 1.0}) {
    const double expected = beyond_a_bent_continuum(face_share);
    for (const double error : of_displacement(Body(bar(6, 4, 3, face_share)), bent).error)
      EXPECT_NEAR(error, expected, 1e-9 * expected);
  }
}

TEST(DisplacementRecovery, OfAPartlyFilledCellItIsTheShareOfThatOfAFullOne) {
  BodyConfig config = bar(5, 4, 3);
  testing::fill_evenly(config, std::vector<float>(60, 0.375F));
  const Body body(config);
  EXPECT_TRUE(DisplacementRecovery(body).has_partial_cells());
  const double expected = 0.375 * beyond_a_bent_continuum(0.5);
  for (const double error : of_displacement(body, bent).error) EXPECT_NEAR(error, expected, 1e-9 * expected);
}

TEST(DisplacementRecovery, OfTwoPartsOfOneMaterialItIsThatOfOne) {
  BodyConfig config = bar(5, 4, 3);
  config.parts = {{.name = "A", .density = config.density, .springs = config.springs}};
  config.contents = {{{0, CellFill::even(0.25F)}, {1, CellFill::even(0.75F)}}};
  config.content_of.assign(60, 0);
  const double expected = beyond_a_bent_continuum(0.5);
  for (const double error : of_displacement(Body(config), bent).error)
    EXPECT_NEAR(error, expected, 1e-9 * expected);
}

// Of a quadratic stretch along an axis lattice and trilinear cells know the mean; C11 a^2 h^5 / 12 is
// missing.
TEST(DisplacementRecovery, SeesWhatTrilinearCellsLack) {
  constexpr double a = 0.02;
  const Body body(bar(4, 4, 4));
  const double c11 = cubic_stiffness(body.config().springs, h).c11;
  const double expected = c11 * a * a * std::pow(h, 5) / 12;
  for (int axis = 0; axis < 3; ++axis)
    for (const double error : of_displacement(body, [&](const Vec3& x) -> Vec3 {
                                return a / 2 * x[axis] * x[axis] * Vec3::Unit(axis);
                              }).error)
      EXPECT_NEAR(error, expected, 1e-9 * expected);
}

TEST(DisplacementRecovery, IsBilinear) {
  const Body body(testing::test_config(VoxelGrid::box(3, 4, 5)));
  SpringSystem<double> system(body, {});
  State<double> first = system.rest_state(), second = first;
  testing::randomise(body, first, 0.2, 0, 6);
  testing::randomise(body, second, 0.2, 0, 7);
  const Field<double> rest = system.rest_state().x;
  Field<double> sum = first.x;
  sum.array() += second.x.array();
  const DisplacementRecovery recovery(body);
  const auto product = [&](const Field<double>& u, const Field<double>& z) {
    return recovery.products({rest, &u}, {rest, &z}).error_of_all();
  };
  const double both = product(first.x, second.x);
  EXPECT_NEAR(product(second.x, first.x), both, 1e-10 * std::abs(both));
  EXPECT_NEAR(product(sum, sum), product(first.x, first.x) + 2 * both + product(second.x, second.x),
              1e-10 * product(sum, sum));
}

/// A random state and a random direction of a body with two materials.
struct RandomState {
  RandomState() : body(config()), x(body.lattice().size), move(x) {
    SpringSystem<double> system(body, {});
    State<double> state = system.rest_state(), other = state;
    testing::randomise(body, state, 0.2, 0, 6);
    testing::randomise(body, other, 0.5, 0, 7);
    x = state.x;
    move = other.x;
    move.array() -= x.array();
  }
  static BodyConfig config() {
    BodyConfig config = testing::test_config(VoxelGrid::box(3, 3, 2));
    testing::add_parts(config);
    testing::fill_randomly(config, 3);
    return config;
  }
  Field<double> ahead(double step) const {
    Field<double> there = x;
    there.array() += step * move.array();
    return there;
  }
  Body body;
  Field<double> x, move;
};

TEST(DisplacementRecovery, StaysAsItIsWhenTheBodyRotates) {
  const RandomState state;
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(2.1, Vec3(1, 2, -1).normalized()) * Eigen::AngleAxisd(0.7, Vec3::UnitZ()))
          .toRotationMatrix();
  Field<double> x = state.x, move = state.move;
  for (const std::ptrdiff_t site : state.body.sites()) {
    x.set(site, turn * state.x.at(site) + Vec3(1, 2, 3));
    move.set(site, turn * state.move.at(site));
  }
  const DisplacementRecovery recovery(state.body);
  const Products before = recovery.products({state.x}, {state.x, &state.move});
  const Products after = recovery.products({x}, {x, &move});
  for (std::size_t cell = 0; cell < before.error.size(); ++cell)
    EXPECT_NEAR(after.error[cell], before.error[cell], 1e-10 * std::abs(before.stored));
}

// eta(x, x) changes along the move by twice eta(x, its derivative).
TEST(DisplacementRecovery, StrainsChangeByTheirDerivative) {
  const RandomState state;
  const DisplacementRecovery recovery(state.body);
  constexpr double step = 1e-5;
  const Field<double> forth = state.ahead(step), back = state.ahead(-step);
  const Products a = recovery.products({forth}, {forth}), b = recovery.products({back}, {back}),
                 change = recovery.products({state.x}, {state.x, &state.move});
  for (std::size_t cell = 0; cell < a.error.size(); ++cell)
    EXPECT_NEAR((a.error[cell] - b.error[cell]) / (2 * step), 2 * change.error[cell], 1e-6 * a.stored);
  EXPECT_NEAR((a.stored - b.stored) / (2 * step), 2 * change.stored, 1e-6 * a.stored);
}

// Uniform strain in two materials that kinks between them: nothing is unresolved.
TEST(DisplacementRecovery, AKinkBetweenPartsIsNoCurvature) {
  BodyConfig config = bar(4, 3, 3);
  config.contents = {{PartFill{}}, {{1, CellFill::even(1)}}};
  for (int cell = 0; cell < 36; ++cell) config.content_of.push_back(cell % 4 < 2 ? 0 : 1);
  Part hard{.name = "hard"};
  hard.springs = calibrate({10 * young, poisson}, h, 0.5);
  config.parts = {hard};
  const Body body(config);
  const double joint = body.config().origin[0] + 2 * h;
  const Products products = of_displacement(body, [&](const Vec3& x) -> Vec3 {
    return {x[0] < joint ? x[0] : joint + (x[0] - joint) / 10, 0, 0};
  });
  for (const double error : products.error) EXPECT_NEAR(error, 0, 1e-12 * products.stored);
}

double share_alone(const BodyConfig& config) {
  const Body body(config);
  return DisplacementRecovery(body).share_alone();
}

TEST(DisplacementRecovery, CountsCellsThatHaveNoNeighbourAlongAnAxis) {
  EXPECT_EQ(share_alone(bar(4, 3, 2)), 0);
  EXPECT_EQ(share_alone(bar(4, 3, 1)), 1);
  BodyConfig plate_with_block = bar(4, 2, 2);
  for (const int i : {2, 3})
    for (const int j : {0, 1}) plate_with_block.voxels.set(i, j, 1, false);
  EXPECT_DOUBLE_EQ(share_alone(plate_with_block), 4.0 / 12);
}

TEST(DisplacementRecovery, RefusesWhatHasNoElasticityOfItsCells) {
  BodyConfig uniform = bar(2, 2, 2), diagonal = uniform, loose = uniform;
  uniform.sharing = Sharing::uniform;
  diagonal.topology = Topology::one_diagonal;
  loose.springs = {.edge = 1, .face = 0, .body = 0, .volume = 0};
  for (const BodyConfig& config : {uniform, diagonal, loose}) {
    const Body body(config);
    EXPECT_THROW(DisplacementRecovery{body}, InputError);
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
  EXPECT_EQ(doerfler_marking({2, 3, 1}, 0.5, {1, 4, 4}), Ids({0, 1}));
}

// Bent in its left part alone, a bar is to be refined there; with a dual displacement bent in its right part,
// where the two meet.
TEST(SplitByEstimate, SplitsWhatIsUnresolvedForBothDisplacements) {
  const RefinedBody body(bar(8, 2, 2), {});
  const double middle = body.config().origin[0] + 4 * h;
  const auto bend = [&](bool left) {
    Field<double> u(body.size());
    for (const std::ptrdiff_t site : body.sites()) {
      const Vec3 x = body.levels()[0].body.rest_position(site);
      u.set(site, (x[0] < middle) == left ? std::pow(x[0] - middle, 3) * Vec3::UnitY() : Vec3(0, 0, 0));
    }
    return u;
  };
  const Field<double> left = bend(true), right = bend(false);
  const RefinementMap map = split_by_estimate(body, left);
  EXPECT_EQ(map.depth(), 1);
  for (const auto& cell : map.split_cells(0)) EXPECT_LT(cell[0], 4);
  EXPECT_GT(map.split_cells(0).size(), 3U);
  const RefinementMap between = split_by_estimate(body, left, &right);
  ASSERT_EQ(between.depth(), 1);
  for (const auto& cell : between.split_cells(0))  // where the stencils of both reach
    EXPECT_THAT(cell[0], ::testing::AllOf(::testing::Ge(3), ::testing::Le(4)));
}

}  // namespace
}  // namespace mss
