// Vibrations against closed forms, dense eigenvalues, and what Lanczos tends to miss: equal frequencies.
#include "integrators/analysis/modes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/shapes.hpp"
#include "core/springs/spring_system.hpp"
#include "integrators/analysis/lobpcg.hpp"
#include "reference/closed_forms.hpp"
#include "reference/fem/fem_system.hpp"
#include "tests/dense_eigenvalues.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

const double turn = 2 * std::numbers::pi;

BodyConfig config(const VoxelGrid& voxels) {
  return {
      .voxels = voxels, .cell_size = 0.25, .springs = calibrate({.young = 1e4, .poisson = 0.3}, 0.25, 0.5)};
}

Eigen::VectorXd dense_frequencies(BodySystem<double>& system, const State<double>& state,
                                  Tangent kind = Tangent::elastic) {
  SparseMatrix k = system.tangents()->pattern(), m = k;
  system.tangents()->values(0, state.x, state.v, {.stiffness = 1, .kind = kind}, k);
  system.tangents()->values(0, state.x, state.v, {.mass = 1}, m);
  return testing::symmetric_eigenvalues(k, m).cwiseMax(0).cwiseSqrt();
}

/// Each mode solves K q = omega^2 M q, and they are M-orthonormal.
void expect_modes(BodySystem<double>& system, const State<double>& state, const std::vector<Mode>& modes) {
  const double scale = system.spectral_bound().omega * system.spectral_bound().omega;
  Field<double> kq(system.size());
  for (std::size_t i = 0; i < modes.size(); ++i) {
    system.tangents()->product(0, state.x, state.v, {.stiffness = 1, .kind = Tangent::elastic},
                               modes[i].shape, kq);
    system.clear_prescribed(kq);
    for (const std::ptrdiff_t site : system.particles())
      EXPECT_LT((kq.at(site) / system.mass(site) - modes[i].omega * modes[i].omega * modes[i].shape.at(site))
                    .norm(),
                1e-9 * scale);
    for (std::size_t j = 0; j <= i; ++j) {
      double product = 0;
      for (const std::ptrdiff_t site : system.particles())
        product += system.mass(site) * modes[i].shape.at(site).dot(modes[j].shape.at(site));
      EXPECT_NEAR(product, i == j ? 1 : 0, 1e-8);
    }
  }
}

// Small bodies are solved densely, larger ones by Lanczos.
TEST(Modes, AreTheDenseOnes) {
  for (const auto& voxels : {VoxelGrid::box(1, 1, 1), VoxelGrid::box(2, 2, 3), VoxelGrid::box(3, 3, 3)}) {
    const Body body(config(voxels));
    SpringSystem<double> system(body, {});
    const State<double> rest = system.rest_state();
    const Eigen::VectorXd all = dense_frequencies(system, rest);
    Work work;
    const Modes slow = slowest_modes(system, rest, 15, work), fast = fastest_mode(system, rest, work);
    ASSERT_EQ(slow.status, Status::ok);
    ASSERT_EQ(slow.modes.size(), 15U);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(slow.modes[std::size_t(i)].omega, 0) << "moves as a whole";
    for (int i = 6; i < 15; ++i) EXPECT_NEAR(slow.modes[std::size_t(i)].omega / all[i], 1, 1e-8);
    expect_modes(system, rest, slow.modes);
    EXPECT_NEAR(fast.modes.front().omega / all[all.size() - 1], 1, 1e-8);
    EXPECT_LT(fast.modes.front().omega, system.spectral_bound().omega);
  }
}

// Compressed to a twentieth, every corner is pushed apart along all of its edges. Without the tangent's
// negative part: such short springs have negative transverse stiffness, which would hide the guard's.
TEST(Modes, OfAGuardedBodyStayBelowTheBoundWhereItIsCompressed) {
  BodyConfig guarded = config(VoxelGrid::box(3, 3, 3));
  guarded.fold_guard = 20;
  const Body body(guarded), plain(config(VoxelGrid::box(3, 3, 3)));
  SpringSystem<double> system(body, {});
  State<double> state = system.rest_state();
  for (int axis = 0; axis < 3; ++axis)
    for (const std::ptrdiff_t site : body.sites()) state.x.axis(axis)[site] *= 0.05;
  const double fastest = dense_frequencies(system, state, Tangent::projected).maxCoeff(),
               bound = guarded_spectral_bound(body).omega;
  EXPECT_LT(fastest, bound);
  EXPECT_GT(fastest, 0.5 * bound);
  EXPECT_GT(fastest, 1.3 * spectral_bound(body).omega);
  EXPECT_EQ(spectral_bound(body).omega, guarded_spectral_bound(plain).omega);
}

TEST(Modes, CanAllBeRequested) {
  const Body body(config(VoxelGrid::box(2, 2, 3)));  // 108 unknowns: beyond the smallest bodies
  SpringSystem<double> system(body, {});
  const State<double> rest = system.rest_state();
  for (const int count : {40, 107, 108, 200}) {
    Work work;
    const Modes slow = slowest_modes(system, rest, count, work);
    ASSERT_EQ(slow.status, Status::ok);
    EXPECT_EQ(slow.modes.size(), std::size_t(std::min(count, 108)));
    EXPECT_GT(slow.modes[6].omega, 0);
  }
}

TEST(Modes, OfABodyHeldEverywhereAreNone) {
  const Body body(config(VoxelGrid::box(1, 1, 1)));
  SpringSystem<double> system(body, {.holds = {{.box = {{0, 0, 0}, {1, 1, 1}}}}});
  Work work;
  EXPECT_TRUE(slowest_modes(system, system.rest_state(), 5, work).modes.empty());
  EXPECT_TRUE(fastest_mode(system, system.rest_state(), work).modes.empty());
}

// A slender bar's slowest vibration is a millionth of its fastest, and no rigid motion.
TEST(Modes, AreNotTakenForRigidMotions) {
  const Body body(config(VoxelGrid::box(1, 1, 200)));
  SpringSystem<double> system(body, {.holds = {{.box = {{0, 0, 0}, {0.25, 0.25, 0}}}}});
  Work work;
  const Modes slow = slowest_modes(system, system.rest_state(), 2, work);
  ASSERT_EQ(slow.status, Status::ok);
  EXPECT_GT(slow.modes[0].omega, 0);
  EXPECT_NEAR(slow.modes[0].omega / slow.modes[1].omega, 1, 1e-4);
}

TEST(Modes, FindBothOfAPair) {
  const Body body(config(VoxelGrid::box(2, 2, 8)));
  const Vec3 end(0.5, 0.5, 0);
  SpringSystem<double> system(body, {.holds = {{.box = {Vec3::Zero(), end}}}});
  const State<double> rest = system.rest_state();
  const Eigen::VectorXd all = dense_frequencies(system, rest);
  for (const int count : {1, 2, 3, 12}) {
    Work work;
    const Modes slow = slowest_modes(system, rest, count, work);
    ASSERT_EQ(slow.modes.size(), std::size_t(count));
    for (int i = 0; i < count; ++i) EXPECT_NEAR(slow.modes[std::size_t(i)].omega / all[i], 1, 1e-8) << count;
  }
}

// With its sides held a bar is a chain of equal masses and springs, at each of its edges the same.
TEST(Modes, OfAHeldBarAreAChains) {
  constexpr int links = 12;
  const Body body(config(VoxelGrid::box(2, 2, links)));
  const double length = links * body.config().cell_size;
  const Box whole{Vec3::Zero(), Vec3(0.5, 0.5, length)}, bottom{Vec3::Zero(), Vec3(0.5, 0.5, 0)};
  SpringSystem<double> system(body,
                              {.holds = {{.box = whole, .axes = {true, true, false}}, {.box = bottom}}});
  Work work;
  const State<double> rest = system.rest_state();
  const Modes slow = slowest_modes(system, rest, int(system.tangents()->unknowns().size()) - 1, work);
  ASSERT_EQ(slow.status, Status::ok);
  const double c11 = cubic_stiffness(body.config().springs, body.config().cell_size).c11;
  for (int mode = 1; mode <= 4; ++mode) {
    const double chain = reference::chain_frequency(c11, body.config().density, length, links, mode);
    double nearest = 1e9;
    for (const Mode& m : slow.modes) nearest = std::min(nearest, std::abs(m.omega / turn / chain - 1));
    EXPECT_LT(nearest, 1e-8) << mode;
  }
  EXPECT_NEAR(
      reference::chain_frequency(c11, 1000, length, 1000, 1) / reference::bar_frequency(c11, 1000, length, 1),
      1, 1e-6);
}

// A body compressed to half its height buckles: the state is unstable.
TEST(Modes, SayWhenAStateIsNotStable) {
  const Body body(config(VoxelGrid::box(3, 3, 3)));
  SpringSystem<double> system(body, {});
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : body.sites()) state.x.axis(2)[site] *= 0.5;
  Work work;
  const Modes slow = slowest_modes(system, state, 3, work);
  EXPECT_EQ(slow.status, Status::not_positive_definite);
  EXPECT_TRUE(slow.modes.empty());
}

/// A turned brick whose cells at the surface are filled in part.
BodyConfig turned_brick() {
  TriangleMesh mesh = box_mesh({-0.6, -0.45, -0.45}, {0.6, 0.45, 0.45});
  const Eigen::AngleAxisd turned(0.4, Vec3(1, 2, 3).normalized());
  for (Vec3& vertex : mesh.vertices) vertex = turned * vertex;
  MeshFill fill = fill_mesh(mesh, {.cell_size = 0.25});
  BodyConfig brick = config(fill.voxels);
  brick.contents = std::move(fill.contents);
  brick.content_of = std::move(fill.content_of);
  return brick;
}

/// Both searches against dense eigenvalues.
void expect_both_searches(BodySystem<double>& system, int count, const std::string& name) {
  const State<double> rest = system.rest_state();
  const Eigen::VectorXd all = dense_frequencies(system, rest);
  for (const ModeSearch search : {ModeSearch::factored, ModeSearch::multigrid}) {
    Work work;
    const Modes slow = slowest_modes(system, rest, count, work, search);
    ASSERT_EQ(slow.status, Status::ok) << name;
    ASSERT_EQ(slow.modes.size(), std::size_t(count)) << name;
    EXPECT_LT(slow.error, 1e-8) << name;
    for (int i = 0; i < count; ++i)
      EXPECT_NEAR(slow.modes[std::size_t(i)].omega, all[i], all[i] < 1e-3 ? 1e-3 : 1e-8 * all[i])
          << name << ", mode " << i + 1;
    expect_modes(system, rest, slow.modes);
  }
}

// A cube has pairs and triples of equal frequencies; counts that cut them in two are the hardest.
TEST(Modes, OfBothSearchesAreTheDenseOnes) {
  BodyConfig hanging = config(VoxelGrid::box(5, 5, 5)), auxetic = hanging;
  auxetic.springs = calibrate({.young = 1e4, .poisson = 0.1}, 0.25, 0.5);
  const Body cube(hanging), brick(turned_brick()), narrow(auxetic),
      mixed(testing::mixed_config(VoxelGrid::box(5, 4, 5), 3));
  const Environment held{.holds = {{.box = {{0, 0, 0}, {1.25, 1.25, 0}}}}};
  SpringSystem<double> free_cube(cube, {}), held_cube(cube, held), held_narrow(narrow, held),
      free_brick(brick, {}), free_mixed(mixed, {});
  for (const int count : {7, 9, 20}) expect_both_searches(free_cube, count, "free cube");
  for (const int count : {1, 2, 10}) expect_both_searches(held_cube, count, "held cube");
  expect_both_searches(held_narrow, 10, "nu = 0.1");
  expect_both_searches(free_brick, 10, "turned brick");
  expect_both_searches(free_mixed, 10, "cells of three parts, filled in part");
}

TEST(Modes, OfFiniteElementsAreTheDenseOnes) {
  BodyConfig solid = config(VoxelGrid::box(5, 4, 4));
  solid.elastic = {.young = 1e4, .poisson = 0.3};
  const Body body(solid);
  for (const SolidLaw& law : solid_laws()) {
    FemSystem free(body, {}, law), held(body, {.holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}}}, law);
    expect_both_searches(free, 9, law.name + ", free");
    expect_both_searches(held, 10, law.name + ", held");
  }
}

/// Eigenvalues below omega^2, by Sylvester's law of inertia.
int count_below(BodySystem<double>& system, const State<double>& state, double omega) {
  SparseMatrix matrix = system.tangents()->pattern();
  system.tangents()->values(0, state.x, state.v,
                            {.mass = -omega * omega, .stiffness = 1, .kind = Tangent::elastic}, matrix);
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  EXPECT_EQ(factor.info(), Eigen::Success);
  return int((factor.vectorD().array() < 0).count());
}

// Large enough for multigrid to be chosen, and slender enough to be factored for the count.
TEST(Modes, OfLargeBodiesAreAllFound) {
  const Body body(config(VoxelGrid::box(35, 7, 7)));
  const Box end{{0, 0, 0}, {0, 1.75, 1.75}};
  for (const Environment& environment : {Environment{}, Environment{.holds = {{.box = end}}}}) {
    SpringSystem<double> system(body, environment);
    const State<double> rest = system.rest_state();
    Work work;
    const Modes slow = slowest_modes(system, rest, 15, work);
    ASSERT_EQ(slow.status, Status::ok);
    EXPECT_EQ(work.linear_solves, 0) << "not factored";
    for (const std::size_t i : {6U, 9U, 14U}) {
      const double just_below = slow.modes[i].omega * (1 - 1e-6);
      const auto slower = std::count_if(slow.modes.begin(), slow.modes.end(),
                                        [&](const Mode& mode) { return mode.omega < just_below; });
      EXPECT_EQ(count_below(system, rest, just_below), slower) << i;
    }
  }
}

// What a block finds at once, and what it says of an empty rest.
TEST(LowestPairs, FindEqualEigenvaluesAndEndEarly) {
  const Eigen::Index unknowns = 300;
  Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(unknowns, 1, 300);
  values.head(6) << 0, 0, 0, 2, 2, 2;
  const BlockMap a = [&](const Eigen::MatrixXd& x, Eigen::MatrixXd& y) { y = values.asDiagonal() * x; };
  const BlockMap inverse = [&](const Eigen::MatrixXd& x, Eigen::MatrixXd& y) {
    y = (values.array() + 0.1).inverse().matrix().asDiagonal() * x;
  };
  LowestSearch search{.unknowns = unknowns, .count = 6, .relative = 1e-9, .absolute = 1e-11};
  const LowestPairs six = lowest_pairs(a, inverse, Eigen::MatrixXd(unknowns, 0), search);
  ASSERT_EQ(six.status, Status::ok);
  EXPECT_LT((six.values - values.head(6)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((six.vectors.transpose() * six.vectors - Eigen::MatrixXd::Identity(6, 6)).norm(), 1e-12);
  search.count = 1;
  search.below = 2.5;
  EXPECT_EQ(lowest_pairs(a, inverse, six.vectors, search).values.size(), 0);
  const LowestPairs left_out = lowest_pairs(a, inverse, six.vectors.leftCols(5), search);
  ASSERT_EQ(left_out.values.size(), 1);
  EXPECT_NEAR(left_out.values[0], 2, 1e-9);
}

}  // namespace
}  // namespace mss
