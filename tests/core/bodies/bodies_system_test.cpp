#include "core/bodies/bodies_system.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "core/base/record.hpp"
#include "core/bodies/contact_surface.hpp"
#include "core/bodies/touch.hpp"
#include "core/mesh/shapes.hpp"
#include "integrators/integrator.hpp"
#include "tests/body_derivatives.hpp"
#include "tests/dense_eigenvalues.hpp"
#include "tests/several_bodies.hpp"

namespace mss {
namespace {

using testing::rubber_block;
using testing::SeveralBodies;

constexpr BodyContact touching{.bodies = true};
constexpr BodyContact smooth{.bodies = true, .friction = 0};

/// Two blocks, of other cells, the upper one pressed a little into the lower and turned.
std::vector<BodyConfig> two_blocks(double press = 0.004) {
  return {rubber_block(VoxelGrid::box(4, 3, 2), Vec3::Zero()),
          rubber_block(VoxelGrid::box(2, 2, 2), Vec3(0.041, 0.021, 0.1 - press), 0.04)};
}

State<double> disturbed(BodiesSystem<double>& system, double by, unsigned seed) {
  State<double> state = system.rest_state();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-by, by);
  for (const std::ptrdiff_t site : system.particles())
    state.x.set(site, state.x.at(site) + Vec3(any(random), any(random), any(random)));
  return state;
}

Vec3 sum_of(const BodiesSystem<double>& system, const Field<double>& f) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : system.particles()) sum += f.at(site);
  return sum;
}
Vec3 moment_of(const BodiesSystem<double>& system, const Field<double>& x, const Field<double>& f) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : system.particles()) sum += x.at(site).cross(f.at(site));
  return sum;
}

/// Forces on a vertex and three corners x are minus the gradient of value(at(x)), and give no momentum.
template <class At, class Value>
void expect_falling(const std::array<Vec3, 4>& x, const TouchForces& forces, const At& at, const Value& value,
                    double rounding, double tolerance) {
  const std::array<Vec3, 4> all{forces.vertex, forces.corners[0], forces.corners[1], forces.corners[2]};
  EXPECT_LT((all[0] + all[1] + all[2] + all[3]).norm(), rounding);
  Vec3 moment = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i) moment += x[i].cross(all[i]);
  EXPECT_LT(moment.norm(), rounding);
  for (std::size_t i = 0; i < 4; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double step = 1e-7;
      std::array<Vec3, 4> above = x, below = x;
      above[i][axis] += step;
      below[i][axis] -= step;
      const auto a = at(above), b = at(below);
      if (!a || !b) continue;
      const double scale = 1 + all[i].norm();
      EXPECT_NEAR((value(*b) - value(*a)) / (2 * step), all[i][axis], tolerance * scale);
    }
}

TEST(Touch, ForcesAreTheGradientOfTheEnergyAndGiveNoMomentum) {
  const TouchLengths lengths{.reach = 0.5, .layer = 0.05, .rim = 0.1};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  int touched = 0, beside = 0;
  while (touched < 300 || beside < 100) {
    std::array<Vec3, 4> x;
    for (Vec3& point : x) point = Vec3(any(random), any(random), any(random));
    const double growth = touched % 2 == 0 ? 0 : most_growth;
    const auto at = [&](const std::array<Vec3, 4>& y) {
      const Vec3 area = (y[2] - y[1]).cross(y[3] - y[1]);
      std::optional<Touch> found = touch(y[0], -area, {y[1], y[2], y[3]}, lengths);
      if (found) found->growth = growth;
      return found;
    };
    const std::optional<Touch> now = at(x);
    if (!now || !(now->depth > 0)) continue;
    ++touched;
    beside += now->beside > 1e-6;
    const auto energy = [&](const Touch& other) { return touch_energy(other, lengths); };
    expect_falling(x, touch_forces(*now, lengths), at, energy, 1e-13, 5e-6);
  }
}

/// By differences, inside triangles and beside them.
TEST(Touch, SlopeIsThatOfTheNearestPointsWeights) {
  const TouchLengths lengths{.reach = 0.5, .layer = 0.05, .rim = 0.3};
  const std::array<double, 3> values{1, 4, 9};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  std::array<int, 3> seen{};  // on a corner, an edge, inside
  while (seen[1] < 100 || seen[2] < 100) {
    std::array<Vec3, 4> x;
    for (Vec3& point : x) point = Vec3(any(random), any(random), any(random));
    const auto at = [&](const std::array<Vec3, 4>& y) {
      const Vec3 area = (y[2] - y[1]).cross(y[3] - y[1]);
      return touch(y[0], -area, {y[1], y[2], y[3]}, lengths);
    };
    const auto value = [&](const Touch& other) {
      return other.nearest[0] * values[0] + other.nearest[1] * values[1] + other.nearest[2] * values[2];
    };
    const std::optional<Touch> now = at(x);
    if (!now || !(now->depth > 0)) continue;
    ++seen[std::size_t(2 - std::count(now->nearest.begin(), now->nearest.end(), 0.0))];
    const TouchForces forces = slope_at_nearest(*now, x[0], {x[1], x[2], x[3]}, values);
    expect_falling(x, forces, at, value, 1e-10, 1e-3);
  }
}

TEST(Touch, IsRoundedOffBehindAValley) {
  const TouchLengths lengths{.reach = 0.5, .layer = 0.05, .rim = 0.1};
  const std::array<Vec3, 3> corners{Vec3(0, -1, 0), Vec3(1, 0, 0.3), Vec3(0, 1, 0)};
  const auto rounded = [&](const Vec3& point) {
    std::optional<Touch> found = touch(point, -Vec3::UnitZ(), corners, lengths);
    round_off(*found, corners);
    return *found;
  };
  const Touch now = rounded(Vec3(0.01, 0.2, -0.2));  // below the edge along y
  EXPECT_NEAR(now.depth, std::hypot(0.01, 0.2), 1e-12);
  EXPECT_NEAR(std::abs(now.edge[1]), 1, 1e-12);
  const TouchForces forces = touch_forces(now, lengths);
  Vec3 moment = Vec3(0.01, 0.2, -0.2).cross(forces.vertex), sum = forces.vertex;
  for (std::size_t i = 0; i < 3; ++i) {
    moment += corners[i].cross(forces.corners[i]);
    sum += forces.corners[i];
  }
  EXPECT_LT(moment.norm(), 1e-15);
  EXPECT_LT(sum.norm(), 1e-15);
  const Eigen::Matrix3d stiffness = touch_stiffness(now, lengths);
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 by = 1e-6 * Vec3::Unit(axis), at(0.01, 0.2, -0.2);
    const Vec3 above = touch_forces(rounded(at + by), lengths).vertex,
               below = touch_forces(rounded(at - by), lengths).vertex;
    EXPECT_LT(((below - above) / 2e-6 - stiffness.col(axis)).norm(), 1e-8);
  }
}

TEST(ContactSurface, FacesOfCellsEncloseThem) {
  VoxelGrid grid(3, 3, 2);
  for (const auto& [i, j, k] :
       std::vector<std::array<int, 3>>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {2, 2, 1}})
    grid.set(i, j, k, true);
  const Body body(rubber_block(grid, Vec3(1, 2, 3), 0.1));
  const TriangleMesh mesh = faces_of_cells(body);
  EXPECT_TRUE(open_edges(mesh).empty());
  EXPECT_NEAR(enclosed_volume(mesh), 5e-3, 1e-15);
}

TEST(ContactSurface, DividedKeepsTheSurface) {
  for (const double longest : {2.0, 0.7, 0.3, 0.11}) {
    const TriangleMesh mesh = divided(box_mesh(Vec3::Zero(), Vec3(1, 0.5, 0.25)), longest);
    EXPECT_TRUE(open_edges(mesh).empty());
    EXPECT_NEAR(surface_area(mesh), 1.75, 1e-12);
    EXPECT_NEAR(enclosed_volume(mesh), 0.125, 1e-12);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto [a, b, c] = mesh.corners(t);
      EXPECT_LE(std::max({(a - b).norm(), (b - c).norm(), (c - a).norm()}), longest);
    }
  }
}

TEST(BodiesSystem, WithoutContactEachBodyMovesAsAlone) {
  const Environment environment{.gravity = Vec3(0, 0, -9.81), .planes = {{.point = Vec3(0, 0, -0.01)}}};
  const std::vector<BodyConfig> configs = two_blocks();
  SeveralBodies<> several(configs, environment);
  State<double> together = several.system().rest_state();
  const IntegratorOptions options{.dt = 5e-4};
  Work work;
  const auto method = find_integrator("verlet").make<double>(options);
  ASSERT_EQ(method->advance(several.system(), together, 0.2, work), Status::ok);
  for (std::size_t i = 0; i < 2; ++i) {
    const Body body(configs[i]);
    SpringSystem<double> alone(body, environment, {.threads = 1});
    State<double> state = alone.rest_state();
    ASSERT_EQ(find_integrator("verlet").make<double>(options)->advance(alone, state, 0.2, work), Status::ok);
    const std::ptrdiff_t first = several.system().levels()[i].first;
    for (const std::ptrdiff_t site : body.sites())
      EXPECT_LT((together.x.at(first + site) - state.x.at(site)).norm(), 1e-13);
  }
}

TEST(BodiesSystem, ForcesAreTheGradientOfTheEnergy) {
  SeveralBodies<> several(two_blocks(), {.gravity = Vec3(0, 0, -1), .contact = smooth});
  State<double> state = disturbed(several.system(), 0.002, 1);
  ASSERT_GT(several.system().contact_at(state)->touches, 8U);
  testing::compare_forces_with_energy(several.system(), state);
}

/// Cells that are nearly empty are softer, which takes nothing from the laws.
TEST(BodiesSystem, NearlyEmptyCellsTouchSoftlyAndOthersDoNot) {
  std::vector<BodyConfig> blocks = two_blocks(0.006);
  const Body full(blocks[0]);
  const ContactSurface even(full, nullptr);
  blocks[0].contents = {{{0, CellFill::even(1)}}, {{0, CellFill::even(0.05F)}}};
  blocks[0].content_of.assign(std::size_t{4} * 3 * 2, 0);
  blocks[0].content_of[blocks[0].voxels.index(0, 0, 1)] = 1;
  const Body uneven(blocks[0]);
  const ContactSurface surface(uneven, nullptr);
  double least = 1, most = 0;
  for (std::size_t v = 0; v < surface.size(); ++v) {
    const double share = surface.mass_per_area(v) / even.mass_per_area(v);
    least = std::min(least, share);
    most = std::max(most, share);
  }
  EXPECT_LT(least, 0.999);
  EXPECT_EQ(most, 1);
  SeveralBodies<> several(blocks, {.contact = smooth});
  State<double> state = disturbed(several.system(), 0.002, 1);
  ASSERT_GT(several.system().contact_at(state)->touches, 8U);
  testing::compare_forces_with_energy(several.system(), state);
  Field<double> f(several.system().size());
  several.system().force(0, state.x, state.v, f);
  EXPECT_LT(sum_of(several.system(), f).norm(), 1e-12 * f.array().abs().sum());
  EXPECT_LT(moment_of(several.system(), state.x, f).norm(), 1e-12 * f.array().abs().sum());
}

TEST(BodiesSystem, FrictionTooKeepsMomentumAndAngularMomentum) {
  SeveralBodies<> several(two_blocks(), {.contact = touching});
  BodiesSystem<double>& system = several.system();
  State<double> state = disturbed(system, 0.002, 2);
  system.memory()->come_to(state);
  SeveralBodies<>::add(system.levels()[1], Vec3(0.001, -0.0005, 0), state.x);
  Field<double> f(system.size()), smooth_force(system.size());
  system.force(0, state.x, state.v, f);
  system.memory()->forget();
  system.force(0, state.x, state.v, smooth_force);
  double friction = 0;
  for (const std::ptrdiff_t site : system.particles())
    friction += (f.at(site) - smooth_force.at(site)).norm();
  const double scale = f.array().abs().sum();
  EXPECT_GT(friction, 1e-3 * scale);
  EXPECT_LT(sum_of(system, f).norm(), 1e-13 * scale);
  EXPECT_LT(moment_of(system, state.x, f).norm(), 1e-13 * scale);
}

TEST(BodiesSystem, TangentsAgreeAndContactIsNearTheDifferencesOfForces) {
  SeveralBodies<> several(two_blocks(), {.contact = smooth});
  BodiesSystem<double>& system = several.system();
  State<double> state = system.rest_state();
  const TangentCoefficients sum{.mass = 2, .damping = 0.3, .stiffness = 5, .kind = Tangent::elastic};
  const Eigen::MatrixXd matrix = testing::tangent_matrix(system, state, sum);
  EXPECT_LT((matrix - matrix.transpose()).norm(), 1e-12 * matrix.norm());
  const Eigen::MatrixXd stiffness = testing::tangent_matrix(system, state, {.stiffness = 1});
  const Eigen::MatrixXd expected = testing::force_differences(system, state, true, 1e-3 * system.cell_size());
  EXPECT_LT(testing::relative_difference(stiffness, expected), 0.02);
  const auto columns = matrix.cols();
  Eigen::VectorXd p = Eigen::VectorXd::Random(columns), product(columns);
  Field<double> direction(system.size()), out(system.size());
  const std::vector<FreeDof>& unknowns = system.tangents()->unknowns();
  for (Eigen::Index i = 0; i < columns; ++i)
    direction.axis(unknowns[std::size_t(i)].axis)[unknowns[std::size_t(i)].site] = p[i];
  system.tangents()->product(0, state.x, state.v, sum, direction, out);
  for (Eigen::Index i = 0; i < columns; ++i)
    product[i] = out.axis(unknowns[std::size_t(i)].axis)[unknowns[std::size_t(i)].site];
  EXPECT_LT((product - matrix * p).norm(), 1e-12 * product.norm());
  std::vector<Eigen::Matrix3d> blocks;
  system.tangents()->diagonal(0, state.x, state.v, sum, blocks);
  for (Eigen::Index b = 0; b < Eigen::Index(blocks.size()); ++b)
    EXPECT_LT((blocks[std::size_t(b)] - matrix.block<3, 3>(3 * b, 3 * b)).norm(), 1e-12 * matrix.norm());
}

TEST(BodiesSystem, TheBoundHoldsWhereBodiesAreDeepInEachOther) {
  for (const double press : {0.002, 0.01, 0.019}) {
    SeveralBodies<> several(two_blocks(press), {.contact = touching});
    BodiesSystem<double>& system = several.system();
    for (const Vec3& by : {Vec3(0, 0, 0), Vec3(0.013, 0.021, 0), Vec3(0.05, -0.02, 0)}) {
      State<double> state = system.rest_state();
      SeveralBodies<>::add(system.levels()[1], by, state.x);
      system.memory()->come_to(state);
      ASSERT_GT(system.contact_at(state)->touches, 3U);
      const Eigen::MatrixXd k = testing::tangent_matrix(system, state, {.stiffness = 1}),
                            m = testing::tangent_matrix(system, state, {.mass = 1});
      const Eigen::VectorXd half = m.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::MatrixXd scaled = half.asDiagonal() * k * half.asDiagonal();
      const double largest = testing::symmetric_eigenvalues(scaled).maxCoeff();
      EXPECT_LT(std::sqrt(largest), system.spectral_bound().omega);
      system.memory()->forget();
    }
  }
}

TEST(BodiesSystem, ThreadsAndARestartChangeNoBit) {
  const Environment environment{.gravity = Vec3(0, 0, -9.81), .planes = {Plane{}}, .contact = touching};
  const auto run = [&](int threads, bool stops) {
    SeveralBodies<> several(two_blocks(), environment, threads);
    State<double> state = several.system().rest_state();
    SeveralBodies<>::add(several.system().levels()[1], Vec3(0.5, 0.1, -1), state.v);
    const auto method = find_integrator("verlet").make<double>({.dt = 2e-4});
    Work work;
    EXPECT_EQ(method->advance(several.system(), state, 0.05, work), Status::ok);
    if (!stops) {
      EXPECT_EQ(method->advance(several.system(), state, 0.1, work), Status::ok);
      return state;
    }
    Record kept;
    kept.keep(several.system());
    method->remember(several.system(), kept);
    Record read(kept.take_bytes());
    SeveralBodies<> again(two_blocks(), environment, threads);
    const auto goes_on = find_integrator("verlet").make<double>({.dt = 2e-4});
    read.keep(again.system());
    goes_on->remember(again.system(), read);
    EXPECT_EQ(goes_on->advance(again.system(), state, 0.1, work), Status::ok);
    return state;
  };
  const State<double> one = run(1, false);
  for (const State<double>& other : {run(2, false), run(1, true)})
    for (Eigen::Index i = 0; i < one.x.array().size(); ++i) ASSERT_EQ(one.x.array()[i], other.x.array()[i]);
}

TEST(BodiesSystem, AMethodThatChoosesItsStepsIsRefused) {
  SeveralBodies<> several(two_blocks(), {.contact = touching});
  State<double> state = several.system().rest_state();
  Work work;
  EXPECT_THROW(find_integrator("cvode_bdf").make<double>({})->advance(several.system(), state, 0.1, work),
               std::exception);
}

}  // namespace
}  // namespace mss
