// The stability of deformed lattices against the program's own forces, the law of Cauchy and Born,
// elasticity, and bodies that are stepped beside the limits.
#include "core/body/phonons.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "core/springs/spring_system.hpp"
#include "reference/large_strain.hpp"
#include "tests/dense_eigenvalues.hpp"

namespace mss {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
constexpr double h = 0.5;
constexpr double pi = std::numbers::pi;

SpringConstants phonon_springs(double poisson, double share = 0.5) {
  return calibrate({.young = 2e4, .poisson = poisson}, h, share);
}

/// Large, with rotation and shear.
Matrix3d phonon_gradient() {
  Matrix3d F;
  F << 1.3, 0.2, -0.1, -0.3, 0.8, 0.15, 0.1, 0.05, 1.1;
  return F;
}

/// A cube deformed by F everywhere.
struct DeformedCube {
  DeformedCube(const SpringConstants& springs, int n, const Matrix3d& F)
      : body({.voxels = VoxelGrid::box(n, n, n), .cell_size = h, .density = 1000, .springs = springs}),
        system(body, {}, {.threads = 1}),
        state(system.undeformed_state()),
        force(system.size()) {
    for (const std::ptrdiff_t site : system.particles()) {
      const Vector3d rest = body.rest_position(site);
      state.x.set(site, F * rest);
      const double edge = n * h;
      if (rest.minCoeff() > h / 2 && rest.maxCoeff() < edge - h / 2) inside.push_back(site);
    }
  }
  const Field<double>& forces() {
    system.force(0, state.x, state.v, force);
    return force;
  }

  Body body;
  SpringSystem<double> system;
  State<double> state;
  Field<double> force;
  std::vector<std::ptrdiff_t> inside;  ///< particles that are not at the surface
};

// K(q) is the sum of exp(i q.n) times minus the change of a particle's force with the place of that at n.
TEST(Phonons, StiffnessOfAWaveIsTheForcesDifferences) {
  for (const double poisson : {0.0, 0.3, 0.45}) {
    const SpringConstants springs = phonon_springs(poisson);
    DeformedCube cube(springs, 4, phonon_gradient());
    const std::ptrdiff_t middle = cube.inside[cube.inside.size() / 2];
    const Vector3d here = cube.body.rest_position(middle);
    for (const Vector3d& q : {Vector3d(0.3, -1.2, 2.9), Vector3d(pi, 0, pi), Vector3d(0.01, 0.02, 0)}) {
      Eigen::Matrix3cd expected = Eigen::Matrix3cd::Zero();
      constexpr double step = 1e-6;
      for (const std::ptrdiff_t site : cube.system.particles()) {
        const Vector3d place = cube.state.x.at(site);
        const auto wave = std::exp(std::complex<double>(0, q.dot(cube.body.rest_position(site) - here) / h));
        for (int axis = 0; axis < 3; ++axis) {
          cube.state.x.set(site, place + step * Vector3d::Unit(axis));
          const Vector3d more = cube.forces().at(middle);
          cube.state.x.set(site, place - step * Vector3d::Unit(axis));
          expected.col(axis) -=
              wave * ((more - cube.forces().at(middle)) / (2 * step)).cast<std::complex<double>>();
        }
        cube.state.x.set(site, place);
      }
      const Matrix3d found = wave_stiffness(springs, h, phonon_gradient(), q);
      EXPECT_LT((expected - found.cast<std::complex<double>>()).norm(), 1e-6 * springs.edge) << q.transpose();
    }
  }
}

TEST(Phonons, StressIsThatOfCauchyAndBorn) {
  const SpringConstants springs = phonon_springs(0.1, 0.25);
  const Matrix3d expected = reference::CauchyBorn(springs, h).stress(phonon_gradient());
  EXPECT_LT((lattice_stress(springs, h, phonon_gradient()) - expected).norm(), 1e-12 * expected.norm());
}

// omega^2 = (k h)^2 K / (rho h^3) of long waves at rest: C11 along and C44 across an edge.
TEST(Phonons, LongWavesAreTheContinuums) {
  const SpringConstants springs = phonon_springs(0.3);
  const CubicStiffness c = cubic_stiffness(springs, h);
  constexpr double q = 1e-3;
  const Matrix3d stiffness = wave_stiffness(springs, h, Matrix3d::Identity(), q * Vector3d::UnitX());
  EXPECT_NEAR(stiffness(0, 0) / (q * q * h * c.c11), 1, 1e-6);
  EXPECT_NEAR(stiffness(1, 1) / (q * q * h * c.c44), 1, 1e-6);
  EXPECT_NEAR(stiffness(0, 1), 0, 1e-12 * stiffness(0, 0));
}

TEST(Phonons, NoWaveIsSofterThanTheSoftest) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> phase(-pi, pi);
  for (const auto& [poisson, share] : {std::pair(0.0, 0.5), {0.3, 0.25}, {0.3, 1.0}}) {
    const SpringConstants springs = phonon_springs(poisson, share);
    for (const StrainPath& path : strain_paths()) {
      const Matrix3d F = strained_gradient(springs, h, path, 0.15);
      const double softest = softest_wave(springs, h, F).stiffness;
      for (int i = 0; i < 2000; ++i) {
        const Vector3d q(phase(random), phase(random), phase(random));
        const double least =
            Eigen::SelfAdjointEigenSolver<Matrix3d>(wave_stiffness(springs, h, F, q)).eigenvalues()[0];
        EXPECT_GE(least / (4 * (q / 2).array().sin().square().sum()), softest - 1e-4 * springs.edge)
            << path.name() << q.transpose();
      }
    }
  }
}

TEST(Phonons, SidesAreFreeOfStress) {
  const SpringConstants springs = phonon_springs(0.4);
  for (const StrainPath& path : strain_paths()) {
    if (path.kind == StrainPath::Kind::shear) continue;
    const Matrix3d F = strained_gradient(springs, h, path, 0.3);
    const Matrix3d stress = lattice_stress(springs, h, F);
    const Eigen::VectorXcd values = testing::any_eigenvalues(stress);
    std::array<double, 3> sizes{std::abs(values[0]), std::abs(values[1]), std::abs(values[2])};
    std::sort(sizes.begin(), sizes.end());
    EXPECT_LT(sizes[1], 1e-8 * sizes[2]) << path.name();
  }
}

// Waves grow where compression or shear is large, at a Poisson's ratio below 1/4 free sides give way before.
TEST(Phonons, LimitsSayWhatGivesWay) {
  struct Case {
    double poisson, share, strain;
    StrainPath path;
    bool of_sides;
  };
  using Kind = StrainPath::Kind;
  for (const Case& c : {Case{0, 0.5, 0.194, {Kind::tension}, true},
                        {-0.2, 0.5, 0.090, {Kind::tension}, true},
                        {0.3, 0.25, 0.298, {Kind::compression}, false},
                        {0.3, 1, 0.349, {Kind::compression, StrainPath::Direction::face_diagonal}, false},
                        {0, 0.5, 0.697, {Kind::shear}, false}}) {
    const SpringConstants springs = phonon_springs(c.poisson, c.share);
    const PhononLimit limit = phonon_limit(springs, h, c.path, 0.9);
    EXPECT_NEAR(limit.strain, c.strain, 1e-3) << c.path.name();
    EXPECT_EQ(limit.is_of_sides(), c.of_sides) << c.path.name();
    EXPECT_TRUE(strained_gradient(springs, h, c.path, limit.strain - 2e-4).allFinite());
    if (c.of_sides) {
      EXPECT_FALSE(strained_gradient(springs, h, c.path, limit.strain + 2e-4).allFinite());
    } else {
      const Matrix3d F = strained_gradient(springs, h, c.path, limit.strain);
      const Matrix3d stiffness = wave_stiffness(springs, h, F, limit.wave.phases);
      EXPECT_LT(Eigen::SelfAdjointEigenSolver<Matrix3d>(stiffness).eigenvalues()[0], 0) << c.path.name();
    }
  }
}

TEST(Phonons, CalibratedSpringsOfCommonRatiosAreStableInTensionAndShear) {
  for (const double poisson : {0.25, 0.3, 0.45, 0.49})
    for (const PhononLimit& limit : least_phonon_limits(phonon_springs(poisson), h)) {
      if (limit.path.kind == StrainPath::Kind::compression)
        EXPECT_GT(limit.strain, 0.45) << poisson;
      else
        EXPECT_TRUE(std::isinf(limit.strain)) << poisson << " " << limit.path.name();
    }
}

// Without face diagonals nothing resists some waves at rest, which compression makes grow at once.
TEST(Phonons, MechanismsAreUnstableInCompression) {
  const SpringConstants springs = phonon_springs(0.3, 0);
  EXPECT_NEAR(softest_wave(springs, h, Matrix3d::Identity()).stiffness, 0, 1e-9 * springs.edge);
  EXPECT_LT(phonon_limit(springs, h, {StrainPath::Kind::compression}, 0.5).strain, 1e-3);
}

// Limits are those of any size and stiffness.
TEST(Phonons, LimitsAreWithoutUnits) {
  const StrainPath path{StrainPath::Kind::compression, StrainPath::Direction::body_diagonal};
  const SpringConstants springs{.edge = 100, .face = 100, .body = 300, .volume = 0};
  const SpringConstants scaled{.edge = 1e7, .face = 1e7, .body = 3e7, .volume = 0};
  const double limit = phonon_limit(springs, 0.2, path, 0.5).strain;
  EXPECT_NEAR(limit, 0.122, 1e-3);
  EXPECT_NEAR(phonon_limit(scaled, 1e-3, path, 0.5).strain, limit, 1e-6);
}

}  // namespace
}  // namespace mss
