// Bodies of cells that are partly filled, and with parts of several materials.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/kernels/sweep.hpp"
#include "core/measures/measures.hpp"
#include "core/measures/particle_measures.hpp"
#include "core/springs/spring_system.hpp"
#include "integrators/analysis/modes.hpp"
#include "tests/differences.hpp"
#include "tests/force_oracle.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

using Dense = Eigen::MatrixXd;

/// Random fills of one part or three; of odd seeds part 0 has no volume force and no body diagonals, which
/// its neighbours have.
BodyConfig random_config(const VoxelGrid& voxels, bool parts, unsigned seed) {
  BodyConfig config = testing::test_config(voxels);
  if (parts) testing::add_parts(config);
  if (seed % 2 == 1) config.springs.body = config.springs.volume = 0;
  testing::fill_randomly(config, seed);
  return config;
}

/// Calls visit(config, name) for random fills of every shape.
template <class Visit>
void for_each_config(Visit&& visit) {
  unsigned seed = 0;
  for (const auto& shape : testing::test_shapes())
    for (const bool parts : {false, true}) {
      visit(random_config(shape.voxels, parts, seed), shape.name + (parts ? " of parts" : ""));
      visit(random_config(shape.voxels, parts, seed + 1), shape.name + " without volume force in part 0");
      seed += 2;
    }
}

template <class Real>
void compare_with_oracle(const BodyConfig& config, const SweepKernel<Real>& kernel, double tolerance,
                         const std::string& name) {
  EXPECT_LT(testing::relative_force_error<Real>(config, kernel.name, 2), tolerance)
      << name << " " << kernel.name;
}

template <class Real>
void compare_all_with_oracle(double tolerance) {
  int checked = 0;
  for_each_config([&](BodyConfig config, const std::string& name) {
    for (const auto topology : {Topology::full, Topology::edges_body, Topology::one_diagonal})
      for (const double guard : {0.0, 10.0})
        for (const auto& kernel : runnable_copies<SweepKernel<Real>>()) {
          config.topology = topology;
          config.fold_guard = guard;
          compare_with_oracle(config, kernel, tolerance, name);
          ++checked;
        }
  });
  EXPECT_EQ(checked, 40 * 3 * 2 * int(runnable_copies<SweepKernel<Real>>().size()));
}

TEST(LocalFill, ForcesEqualOracleInDouble) { compare_all_with_oracle<double>(1e-12); }
TEST(LocalFill, ForcesEqualOracleInSingle) { compare_all_with_oracle<float>(1e-5); }

TEST(LocalFill, MassesSpringsAndEnergyEqualTheOracles) {
  for_each_config([](BodyConfig config, const std::string& name) {
    config.fold_guard = 10;
    config.fill_blend_springs = config.fill_blend_mass = 0.2;
    const Body body(config);
    SpringSystem<double> system(body, {});
    reference::Algorithm1 oracle(config, Vec3::Zero(), 1);
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0.4, 0, 3);
    testing::copy_state(body, state, oracle);
    EXPECT_EQ(body.spring_count(), oracle.springs().size()) << name;
    double sum = 0, by_contents = 0;
    for (std::size_t id = 0; id < body.particle_count(); ++id) {
      EXPECT_NEAR(body.mass(body.sites()[id]), oracle.particles()[id].mass, 1e-14 * body.total_mass());
      sum += oracle.particles()[id].mass;
    }
    body.for_each_cell([&](std::ptrdiff_t site) {
      for (const auto& [part, fill] : body.content_at(site))
        by_contents += body.parts()[std::size_t(part)].density * double(fill.share()) * body.cell_volume();
    });
    EXPECT_NEAR(body.total_mass(), sum, 1e-13 * sum) << name;
    EXPECT_NEAR(body.total_mass(), by_contents, 1e-6 * sum) << name;  // single precision
    const StoredEnergy energy = system.stored_energy(state.x);
    EXPECT_NEAR(energy.elastic + energy.volume, oracle.potential_energy(), 1e-12 * energy.elastic) << name;
  });
}

TEST(LocalFill, ForcesAreTheGradientOfTheEnergy) {
  for_each_config([](BodyConfig config, const std::string& name) {
    config.damping = {};
    for (Part& part : config.parts) part.damping = {};
    config.fold_guard = 3;
    const Body body(config);
    SpringSystem<double> system(body, {});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0.4, 0, 9);
    Field<double> force(system.size());
    system.force(0, state.x, state.v, force);
    const auto energy = [&] {
      const StoredEnergy e = system.stored_energy(state.x);
      return e.elastic + e.volume;
    };
    constexpr double step = 1e-6;
    for (std::size_t p = 0; p < body.particle_count(); p += 1 + body.particle_count() / 7)
      for (int axis = 0; axis < 3; ++axis) {
        double& x = state.x.axis(axis)[body.sites()[p]];
        const double at = x;
        x = at + step;
        const double above = energy();
        x = at - step;
        const double slope = (above - energy()) / (2 * step);
        x = at;
        EXPECT_NEAR(-slope, force.axis(axis)[body.sites()[p]], 1e-5 * force.array().abs().maxCoeff()) << name;
      }
  });
}

struct FillScenario {
  explicit FillScenario(const BodyConfig& config, const std::string& kernel = {})
      : body(config), system(body, {}, {2, kernel}), state(system.rest_state()) {
    testing::randomise(body, state, 0.4, 0.5, 5);
  }
  Dense tangent(const TangentCoefficients& sum) {
    SparseMatrix matrix = system.tangents()->pattern();
    system.tangents()->values(0, state.x, state.v, sum, matrix);
    return matrix;
  }
  Body body;
  SpringSystem<double> system;
  State<double> state;
};

TEST(LocalFill, TangentsAreTheDerivatives) {
  int checked = 0;
  for_each_config([&](BodyConfig config, const std::string& name) {
    if (config.voxels.count() > 40) return;
    config.fold_guard = 5;
    FillScenario s(config);
    for (const bool of_positions : {true, false}) {
      const TangentCoefficients sum{
          .damping = of_positions ? 0.0 : 1.0, .stiffness = of_positions ? 1.0 : 0.0, .kind = Tangent::exact};
      EXPECT_LT(
          testing::relative_difference(
              s.tangent(sum), testing::force_differences(s.system, s.state, of_positions, config.cell_size)),
          1e-6)
          << name;
    }
    ++checked;
  });
  EXPECT_EQ(checked, 3 * 4);
}

TEST(LocalFill, ProductsAndDiagonalsAreTheMatrixs) {
  int checked = 0;
  for_each_config([&](BodyConfig config, const std::string& name) {
    if (config.voxels.count() > 40) return;
    config.fold_guard = 5;
    for (const auto& kernel : runnable_copies<SweepKernel<double>>())
      for (const auto kind : {Tangent::elastic, Tangent::projected}) {
        FillScenario s(config, kernel.name);
        const TangentCoefficients sum{.mass = 2, .damping = 0.3, .stiffness = 5, .kind = kind};
        const Dense matrix = s.tangent(sum);
        Field<double> product(s.system.size());
        s.system.tangents()->product(0, s.state.x, s.state.v, sum, s.state.v, product);
        std::vector<Eigen::Matrix3d> diagonal;
        s.system.tangents()->diagonal(0, s.state.x, s.state.v, sum, diagonal);
        Eigen::VectorXd along(matrix.rows()), result(matrix.rows());
        Dense blocks = Dense::Zero(matrix.rows(), 3), expected = blocks;
        for (std::size_t p = 0; p < s.body.particle_count(); ++p) {
          const auto row = 3 * Eigen::Index(p);
          along.segment<3>(row) = s.state.v.at(s.body.sites()[p]);
          result.segment<3>(row) = product.at(s.body.sites()[p]);
          blocks.middleRows<3>(row) = diagonal[p];
          expected.middleRows<3>(row) = matrix.block<3, 3>(row, row);
        }
        EXPECT_LT(testing::relative_difference(result, matrix * along), 1e-12) << name << " " << kernel.name;
        EXPECT_LT(testing::relative_difference(blocks, expected), 1e-12) << name << " " << kernel.name;
        ++checked;
      }
  });
  EXPECT_EQ(checked, 3 * 4 * 2 * int(runnable_copies<SweepKernel<double>>().size()));
}

TEST(LocalFill, KeepsLinearAndAngularMomentum) {
  for_each_config([](BodyConfig config, const std::string& name) {
    config.fold_guard = 10;
    FillScenario s(config);
    Field<double> force(s.system.size());
    s.system.force(0, s.state.x, s.state.v, force);
    Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
    double forces = 0, torques = 0;
    for (const std::ptrdiff_t site : s.body.sites()) {
      sum += force.at(site);
      torque += s.state.x.at(site).cross(force.at(site));
      forces += force.at(site).norm();
      torques += s.state.x.at(site).norm() * force.at(site).norm();
    }
    EXPECT_LT(sum.norm(), 1e-13 * forces) << name;
    EXPECT_LT(torque.norm(), 1e-13 * torques) << name;
  });
}

TEST(LocalFill, RigidMotionMeetsNoForce) {
  for_each_config([](BodyConfig config, const std::string& name) {
    config.fold_guard = 10;
    const Body body(config);
    SpringSystem<double> system(body, {});
    State<double> state = system.rest_state();
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vec3(1, -2, 3).normalized()).toRotationMatrix();
    const Vec3 spin(0.7, 0.2, -0.5);
    for (const std::ptrdiff_t site : body.sites()) {
      state.x.set(site, turn * state.x.at(site) + Vec3(3, 2, 1));
      state.v.set(site, spin.cross(state.x.at(site)) + Vec3(1, 0, 2));
    }
    Field<double> force(system.size());
    system.force(0, state.x, state.v, force);
    EXPECT_LT(force.array().abs().maxCoeff(), 1e-12 * config.cell_size * 2500) << name;
  });
}

template <class Real>
void compare_threads() {
  for_each_config([](BodyConfig config, const std::string& name) {
    config.fold_guard = 5;
    const Body body(config);
    std::vector<State<Real>> ends;
    for (const int threads : {1, 2, 3, 8}) {
      SpringSystem<Real> system(body, {.gravity = Vec3(0, 0, -9.81)}, {threads});
      State<Real> state = system.rest_state();
      testing::randomise(body, state, 0.3, 0.5, 3);
      system.kick_drift({.kick_before = 5e-4, .kick_after = 5e-4, .drift_new = 1e-3}, 1e-3, 20, state);
      ends.push_back(state);
    }
    for (const State<Real>& end : ends)
      for (const std::ptrdiff_t site : body.sites()) {
        ASSERT_EQ(end.x.at(site), ends[0].x.at(site)) << name;
        ASSERT_EQ(end.v.at(site), ends[0].v.at(site)) << name;
      }
    EXPECT_TRUE(ends[0].x.array().isFinite().all());
  });
}

TEST(LocalFill, IsTheSameForAnyThreadsInDouble) { compare_threads<double>(); }
TEST(LocalFill, IsTheSameForAnyThreadsInSingle) { compare_threads<float>(); }

/// Sum of f x^T over the corners of a cell alone that is filled so, deformed affinely: volume times mean
/// stress.
Eigen::Matrix3d virial(BodyConfig config, const CellContent& content, const Eigen::Matrix3d& deformation) {
  config.voxels = VoxelGrid::box(1, 1, 1);
  config.contents = {content};
  config.content_of = {0};
  const Body body(config);
  SpringSystem<double> system(body, {}, {1});
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : body.sites()) state.x.set(site, deformation * state.x.at(site));
  Field<double> force(system.size());
  system.force(0, state.x, state.v, force);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const std::ptrdiff_t site : body.sites()) sum -= force.at(site) * body.rest_position(site).transpose();
  return sum;
}

// Four quarters at parallel edges, and two halves at opposite faces, make a whole.
TEST(LocalFill, UniformStrainGivesEveryCellItsShareOfTheStress) {
  Eigen::Matrix3d deformation;
  deformation << 1.2, 0.1, -0.05, 0.2, 0.9, 0.15, -0.1, 0.05, 1.1;
  int checked = 0;
  for (const unsigned seed : {2U, 3U}) {
    const BodyConfig config = random_config(VoxelGrid::box(3, 3, 3), true, seed);
    for (const CellContent& content : config.contents) {
      Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
      for (const auto& [part, fill] : content)
        expected += double(fill.share()) * virial(config, {{part, CellFill::even(1)}}, deformation);
      EXPECT_LT((virial(config, content, deformation) - expected).norm(), 2e-7 * expected.norm());
      ++checked;
    }
  }
  EXPECT_EQ(checked, 24);
}

// So the stress of every cell above is that in the body.
TEST(LocalFill, ABodyIsTheSumOfItsCells) {
  BodyConfig config = random_config(VoxelGrid::box(4, 3, 3), true, 2);
  config.damping = {};
  for (Part& part : config.parts) part.damping = {};
  FillScenario s(config);
  Field<double> force(s.system.size()), sum(s.system.size());
  s.system.force(0, s.state.x, s.state.v, force);
  s.body.for_each_cell([&](std::ptrdiff_t site) {
    BodyConfig alone = config;
    alone.voxels = VoxelGrid::box(1, 1, 1);
    alone.contents = {s.body.content_at(site)};
    alone.content_of = {0};
    const Body cell(alone);
    SpringSystem<double> system(cell, {}, {1});
    State<double> state = system.rest_state();
    for (int c = 0; c < 8; ++c)
      state.x.set(cell.lattice().corner(c), s.state.x.at(site + s.body.lattice().corner(c)));
    Field<double> own(system.size());
    system.force(0, state.x, state.v, own);
    for (int c = 0; c < 8; ++c) {
      const std::ptrdiff_t at = site + s.body.lattice().corner(c);
      sum.set(at, sum.at(at) + own.at(cell.lattice().corner(c)));
    }
  });
  EXPECT_LT((sum.array() - force.array()).abs().maxCoeff(), 1e-12 * force.array().abs().maxCoeff());
}

TEST(LocalFill, VolumeIsOfWhatIsFilled) {
  for_each_config([](BodyConfig config, const std::string& name) {
    const Body body(config);
    SpringSystem<double> system(body, {}, {1});
    State<double> state = system.rest_state();
    EXPECT_NEAR(measure(system, state).volume_ratio, 1, 1e-13) << name;
    for (const std::ptrdiff_t site : body.sites()) {  // a layer of z so thick as its height
      const Vec3 x = state.x.at(site) - config.origin;
      state.x.set(site, Vec3(2 * x[0], 3 * x[1], x[2] * (1 + x[2])));
    }
    double volume = 0, at_rest = 0;
    const VoxelGrid& voxels = config.voxels;
    const double h = config.cell_size;
    for (int k = 0; k < voxels.nz(); ++k)
      for (int j = 0; j < voxels.ny(); ++j)
        for (int i = 0; i < voxels.nx(); ++i)
          for (const auto& [part, fill] : config.contents[config.content_of[voxels.index(i, j, k)]]) {
            if (!voxels.at(i, j, k)) continue;
            at_rest += double(fill.share()) * h * h * h;
            volume += double(fill.share()) * 6 * h * h * h * (1 + (2 * k + 1) * h);
          }
    EXPECT_NEAR(body.volume(), at_rest, 1e-6 * at_rest) << name;
    EXPECT_NEAR(measure(system, state).volume_ratio, volume / at_rest, 1e-6 * volume / at_rest) << name;
    EXPECT_NEAR(measure(system, state).volume_ratio_thesis, volume / at_rest, 1e-6 * volume / at_rest)
        << name;
  });
}

TEST(LocalFill, VolumeAtAParticleIsOfWhatIsFilled) {
  BodyConfig config = testing::test_config(VoxelGrid::box(2, 1, 1));
  testing::fill_evenly(config, {0.25F, 1});
  const Body body(config);
  SpringSystem<double> system(body, {}, {1});
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : body.sites()) {  // the first cell twice as long
    const Vec3 x = state.x.at(site);
    if (x[0] < config.origin[0] + 0.1) state.x.set(site, x - Vec3(config.cell_size, 0, 0));
  }
  EXPECT_NEAR(volume_ratio_at({body}, state.x, body.lattice().site(0, 0, 0)), 2, 1e-14);
  EXPECT_NEAR(volume_ratio_at({body}, state.x, body.lattice().site(1, 0, 0)), (0.25 * 2 + 1) / 1.25, 1e-14);
}

/// Young's modulus of a bar along x whose ends are moved apart along x and free across, to first order.
double young_of(const BodyConfig& config) {
  const Body body(config);
  SpringSystem<double> system(body, {}, {1});
  const State<double> state = system.rest_state();
  SparseMatrix matrix = system.tangents()->pattern();
  system.tangents()->values(0, state.x, state.v, {.stiffness = 1}, matrix);
  const Dense stiffness = matrix;
  const double length = config.cell_size * config.voxels.nx(),
               area = config.cell_size * config.voxels.ny() * config.cell_size * config.voxels.nz();
  const auto& unknowns = system.tangents()->unknowns();
  std::vector<Eigen::Index> free, pulled;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const Vec3 at = (body.rest_position(unknowns[i].site) - config.origin) / config.cell_size;
    const int axis = unknowns[i].axis;
    const bool ends = axis == 0 && (at[0] < 0.5 || at[0] > config.voxels.nx() - 0.5);
    if (axis == 0 && at[0] > config.voxels.nx() - 0.5) pulled.push_back(Eigen::Index(i));
    // Nor does it float across or turn about x.
    const bool first = at.norm() < 0.5 && axis > 0, second = (at - Vec3::UnitY()).norm() < 0.5 && axis == 2;
    if (!ends && !first && !second) free.push_back(Eigen::Index(i));
  }
  Eigen::VectorXd u = Eigen::VectorXd::Zero(stiffness.rows());
  for (const Eigen::Index i : pulled) u[i] = 1;
  const Eigen::VectorXd load = -(stiffness * u)(free);
  const Eigen::VectorXd solution = Dense(stiffness(free, free)).ldlt().solve(load);
  u(free) = solution;
  return (stiffness * u)(pulled).sum() / area * length;
}

/// Two materials of this Poisson's ratio, cells of part 1 where `second` says.
BodyConfig bar(double poisson, const std::array<int, 3>& cells, double young0, double young1,
               const std::function<bool(int, int, int)>& second) {
  BodyConfig config{.voxels = VoxelGrid::box(cells[0], cells[1], cells[2]), .cell_size = 0.25};
  config.fill({.young = young0, .poisson = poisson}, 0.5);
  config.parts = {{.springs = calibrate({.young = young1, .poisson = poisson}, config.cell_size, 0.5)}};
  config.contents = {{{0, CellFill::even(1)}}, {{1, CellFill::even(1)}}};
  for (int k = 0; k < cells[2]; ++k)
    for (int j = 0; j < cells[1]; ++j)
      for (int i = 0; i < cells[0]; ++i) config.content_of.push_back(second(i, j, k) ? 1 : 0);
  return config;
}

// One behind the other they bear the same stress. Unless Poisson's ratio is 0 they would narrow differently,
// and hold each other at the joint.
TEST(TwoMaterials, InSeriesHaveTheHarmonicMeanOfTheirStiffness) {
  for (const double ratio : {2.0, 50.0}) {
    const BodyConfig config = bar(0, {8, 2, 2}, 1e5, ratio * 1e5, [](int i, int, int) { return i >= 6; });
    const double expected = 1e5 / (0.75 + 0.25 / ratio);
    EXPECT_NEAR(young_of(config), expected, 1e-9 * expected) << ratio;
  }
}

// Side by side they have the same strain; of equal Poisson's ratio they narrow alike.
TEST(TwoMaterials, InParallelHaveTheMeanOfTheirStiffness) {
  for (const double poisson : {0.0, 0.3, 0.45})
    for (const double ratio : {2.0, 50.0}) {
      const BodyConfig config =
          bar(poisson, {4, 4, 2}, 1e5, ratio * 1e5, [](int, int j, int) { return j == 3; });
      const double expected = 1e5 * (0.75 + 0.25 * ratio);
      EXPECT_NEAR(young_of(config), expected, 1e-9 * expected) << poisson << " " << ratio;
    }
}

// The joint may run through the middle of cells, and the surface too: the layer from y = 3 h to 3.5 h is the
// other material's, and beyond is nothing, or the first. Spread evenly over its cell that is exact; locally,
// the forces across, which cancel in a cell, do not at its corners: where z ends, the strain is not uniform.
TEST(TwoMaterials, InParallelMayShareCells) {
  BodyConfig config = bar(0.3, {4, 4, 2}, 1e5, 5e5, [](int, int j, int) { return j == 3; });
  constexpr float none = 0;
  const CellContent half{{1, testing::fill_of({1, 1, none, none, 1, 1, none, none})}};
  CellContent halves = half;
  halves.push_back({0, testing::fill_of({none, none, 1, 1, none, none, 1, 1})});
  for (const auto& [content, expected] : {std::pair(half, 1e5 * (0.75 + 0.625)), {halves, 1.5e5}}) {
    config.contents[1] = content;
    config.fill_blend_springs = 1;
    EXPECT_NEAR(young_of(config), expected, 1e-9 * expected);
    config.fill_blend_springs = 0.3;
    EXPECT_NEAR(young_of(config), expected, 1e-3 * expected);
    EXPECT_LT(young_of(config), expected * (1 - 1e-4));
  }
}

// No explicit method may step further than the real frequency allows, and the bound is not far from it.
TEST(LocalFill, TheSpectralBoundHolds) {
  for_each_config([](const BodyConfig& config, const std::string& name) {
    const Body body(config);
    SpringSystem<double> system(body, {}, {1});
    const State<double> rest = system.rest_state();
    Work work;
    const Modes fastest = fastest_mode(system, rest, work);
    ASSERT_EQ(fastest.status, Status::ok);
    const double real = fastest.modes.front().omega;
    EXPECT_GE(spectral_bound(body).omega, real * (1 - 1e-9)) << name;
    EXPECT_LT(spectral_bound(body).omega, 2 * real) << name;
  });
}

}  // namespace
}  // namespace mss
