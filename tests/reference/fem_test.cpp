// Finite elements: stresses and tangents against differences, the patch test, large rotations, and the
// interface that every integrator drives.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>
#include <random>

#include "core/base/error.hpp"
#include "core/measures/measures.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "reference/fem/fem_system.hpp"
#include "tests/dense_eigenvalues.hpp"
#include "tests/differences.hpp"
#include "tests/driven.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

using Eigen::Matrix3d;
constexpr Lame lame{.mu = 300, .lambda = 700};

BodyConfig fem_config(const VoxelGrid& voxels, double zeta = 0) {
  BodyConfig config = testing::test_config(voxels);
  config.elastic = {.young = 1e4, .poisson = 0.3};
  config.springs = calibrate(*config.elastic, config.cell_size, 0.5);
  config.damping = {.law = zeta > 0 ? Damping::Law::ratio : Damping::Law::none, .zeta = zeta};
  return config;
}

/// Deformation gradients near rest, far from it, rotated, and inverted.
std::vector<Matrix3d> gradients() {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Matrix3d> all;
  for (const double amplitude : {0.01, 0.3, 1.5})
    for (int i = 0; i < 40; ++i) {
      const Matrix3d rotation =
          Eigen::Quaterniond(uniform(random), uniform(random), uniform(random), uniform(random))
              .normalized()
              .toRotationMatrix();
      const Matrix3d noise = Matrix3d::NullaryExpr([&] { return amplitude * uniform(random); });
      all.push_back(rotation * (Matrix3d::Identity() + noise));
    }
  return all;
}

class Law : public ::testing::TestWithParam<std::string> {
 protected:
  const SolidLaw& law() const {
    for (const SolidLaw& l : solid_laws())
      if (l.name == GetParam()) return l;
    throw std::logic_error("no such law");
  }
};

TEST_P(Law, StressIsTheSlopeOfTheEnergy) {
  for (const Matrix3d& f : gradients()) {
    const Matrix3d stress = law().stress(lame, f);
    for (int i = 0; i < 9; ++i) {
      Matrix3d plus = f, minus = f;
      plus.data()[i] += 1e-5;
      minus.data()[i] -= 1e-5;
      EXPECT_NEAR(stress.data()[i], (law().energy(lame, plus) - law().energy(lame, minus)) / 2e-5,
                  1e-7 * (1000 + stress.norm()));
    }
  }
}

TEST_P(Law, StiffnessIsTheSlopeOfTheStress) {
  for (const Matrix3d& f : gradients()) {
    // Where two stretches nearly cancel the corotated frame rotates faster than differences resolve.
    const Vec3 s = f.jacobiSvd().singularValues();
    if (f.determinant() < 0 && s[1] - s[2] < 0.2) continue;
    const Matrix9 stiffness = law().stiffness(lame, f, false);
    for (int i = 0; i < 9; ++i) {
      Matrix3d plus = f, minus = f;
      plus.data()[i] += 1e-6;
      minus.data()[i] -= 1e-6;
      const Matrix3d slope = (law().stress(lame, plus) - law().stress(lame, minus)) / 2e-6;
      EXPECT_LT((stiffness.col(i) - Eigen::Map<const Eigen::Matrix<double, 9, 1>>(slope.data())).norm(),
                1e-6 * stiffness.norm());
    }
  }
}

TEST_P(Law, ProjectedStiffnessIsNeverNegative) {
  for (const Matrix3d& f : gradients()) {
    const Matrix9 projected = law().stiffness(lame, f, true), exact = law().stiffness(lame, f, false);
    const Eigen::VectorXd after = testing::symmetric_eigenvalues(projected);
    EXPECT_GT(after[0], -1e-10 * after[8]);
    if (testing::symmetric_eigenvalues(exact)[0] > 0) {
      EXPECT_LT((projected - exact).norm(), 1e-10 * exact.norm());
    }
  }
}

TEST(Laws, OfACellsPointsTogetherAreThoseOfEach) {
  int tried = 0;
  for (const SolidLaw& law : solid_laws()) {
    if (!law.stresses || law.stiffnesses) continue;
    ++tried;
    const std::vector<Matrix3d> all = gradients();
    for (std::size_t first = 0; first + 8 <= all.size(); first += 4) {
      PointMatrices f, together;
      std::copy_n(all.begin() + std::ptrdiff_t(first), 8, f.begin());
      law.stresses(lame, f, together);
      double energy = 0;
      for (std::size_t p = 0; p < f.size(); ++p) {
        const Matrix3d alone = law.stress(lame, f[p]);
        EXPECT_LT((together[p] - alone).norm(), 1e-12 * (lame.mu + alone.norm())) << law.name;
        energy += law.energy(lame, f[p]);
      }
      EXPECT_NEAR(law.energies(lame, f), energy, 1e-12 * energy) << law.name;
    }
  }
  EXPECT_GT(tried, 0);
}

const SolidLaw& law_named(const std::string& name) {
  for (const SolidLaw& law : solid_laws())
    if (law.name == name) return law;
  throw std::logic_error("no such law");
}

// The mean of changes of volume that are alike is each of them: such a cell is that of the law without it.
TEST(MeanDilatation, ChangesNothingWhereACellDeformsAlike) {
  for (const auto* name : {"linear", "corotational"}) {
    const SolidLaw &plain = law_named(name), &mean = law_named(std::string(name) + "_mean_dilatation");
    for (const Matrix3d& f : gradients()) {
      PointMatrices alike, stress;
      alike.fill(f);
      mean.stresses(lame, alike, stress);
      const Matrix3d expected = plain.stress(lame, f);
      for (const Matrix3d& at_point : stress)
        EXPECT_LT((at_point - expected).norm(), 1e-12 * (lame.mu + expected.norm())) << mean.name;
      EXPECT_NEAR(mean.energies(lame, alike), 8 * plain.energy(lame, f),
                  1e-11 * (1 + 8 * plain.energy(lame, f)));
    }
  }
}

// With other dilatations at its points a cell is softer, by kappa / 2 times their variance.
TEST(MeanDilatation, LeavesOutTheVarianceOfTheDilatation) {
  const SolidLaw &plain = law_named("linear"), &mean = law_named("linear_mean_dilatation");
  const std::vector<Matrix3d> all = gradients();
  PointMatrices f;
  std::copy_n(all.begin(), 8, f.begin());
  double energy = 0, sum = 0, squares = 0;
  for (const Matrix3d& at_point : f) {
    energy += plain.energy(lame, at_point);
    const double theta = at_point.trace() - 3;
    sum += theta;
    squares += theta * theta;
  }
  const double kappa = lame.lambda + 2 * lame.mu / 3;
  EXPECT_NEAR(mean.energies(lame, f), energy - kappa / 2 * (squares - sum * sum / 8), 1e-10 * energy);
}

/// Deflection of a cantilever of 8 x 2 x 2 cells and 4 x 1 x 1 m under a force at its tip, over that of
/// Timoshenko's beam; both for a force of 1 N.
double tip_deflection(const SolidLaw& law, double poisson) {
  constexpr double length = 4, young = 1e6;
  BodyConfig config{.voxels = VoxelGrid::box(8, 2, 2), .cell_size = 0.5};
  config.fill({.young = young, .poisson = poisson}, 0.5);
  const Body body(config);
  Environment environment{.holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}},
                          .loads = {{.box = {{length, 0, 0}, {length, 1, 1}}, .force = {0, 0, 1}}}};
  FemSystem system(body, environment, law);
  State<double> state = system.rest_state();
  Work work;
  EXPECT_EQ(find_integrator("static").make<double>({.tolerance = 1e-10})->advance(system, state, 1, work),
            Status::ok);
  double tip = 0;
  const std::vector<std::ptrdiff_t> end = body.select({length, 0, 0}, {length, 1, 1});
  for (const std::ptrdiff_t site : end)
    tip += (state.x.at(site) - body.rest_position(site))[2] / double(end.size());
  const double shear = young / (2 * (1 + poisson)), shear_factor = 10 * (1 + poisson) / (12 + 11 * poisson);
  return tip / (length * length * length / (3 * young / 12) + length / (shear_factor * shear));
}

// Elements of full integration lock: two across, they hardly bend as nu nears 1/2.
TEST(MeanDilatation, DoesNotLockWhereTheFullIntegrationDoes) {
  for (const auto* name : {"linear", "corotational"}) {
    const SolidLaw &plain = law_named(name), &mean = law_named(std::string(name) + "_mean_dilatation");
    EXPECT_LT(tip_deflection(plain, 0.45), 0.8) << name;
    EXPECT_LT(tip_deflection(plain, 0.499), 0.35) << name;
    EXPECT_GT(tip_deflection(mean, 0.45), 0.8) << name;
    EXPECT_NEAR(tip_deflection(mean, 0.499) / tip_deflection(mean, 0.45), 1, 0.05) << name;
  }
}

/// Whether a system's products and diagonal blocks are those of one that has kept nothing.
bool are_fresh(FemSystem& system, const Body& body, const SolidLaw& law, const State<double>& state,
               const TangentCoefficients& sum) {
  Field<double> direction(system.size()), product(system.size()), expected(system.size());
  for (const std::ptrdiff_t site : system.particles()) direction.set(site, Vec3(1, double(site), 2));
  FemSystem other(body, {}, law);
  std::vector<Matrix3d> blocks, expected_blocks;
  system.tangents()->product(0, state.x, state.v, sum, direction, product);
  other.tangents()->product(0, state.x, state.v, sum, direction, expected);
  system.tangents()->diagonal(0, state.x, state.v, sum, blocks);
  other.tangents()->diagonal(0, state.x, state.v, sum, expected_blocks);
  return (product.array() == expected.array()).all() && blocks == expected_blocks;
}

TEST_P(Law, KeptTangentsFollowWhatTheyDependOn) {
  const Body body(fem_config(VoxelGrid::box(2, 2, 2), 0.2));
  FemSystem system(body, {}, law());
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.1, 0.1, 1);
  TangentCoefficients sum{.mass = 2, .damping = 0.1, .stiffness = 0.3, .kind = Tangent::elastic};
  EXPECT_TRUE(are_fresh(system, body, law(), state, sum));
  sum.stiffness = 0.7;
  EXPECT_TRUE(are_fresh(system, body, law(), state, sum));
  sum.damping = 0.4;
  EXPECT_TRUE(are_fresh(system, body, law(), state, sum));
  sum.mass = 5;
  EXPECT_TRUE(are_fresh(system, body, law(), state, sum));
  for (const Tangent kind : {Tangent::projected, Tangent::exact}) {
    sum.kind = kind;
    EXPECT_TRUE(are_fresh(system, body, law(), state, sum));
  }
  state.v.set(system.particles()[3], Vec3(5, 6, 7));
  EXPECT_TRUE(are_fresh(system, body, law(), state, sum));
  state.x.set(system.particles()[3], state.x.at(system.particles()[3]) + Vec3(0.01, 0, 0));
  EXPECT_TRUE(are_fresh(system, body, law(), state, sum));
}

TEST_P(Law, ForceIsTheSlopeOfTheStoredEnergy) {
  const Body body(fem_config(VoxelGrid::box(2, 2, 1)));
  FemSystem system(body, {}, law());
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.2, 0, 7);
  Field<double> force(system.size());
  system.force(0, state.x, state.v, force);
  const double step = 1e-6 * body.config().cell_size, largest = force.array().abs().maxCoeff();
  for (const auto [site, axis] : system.tangents()->unknowns()) {
    double& x = state.x.axis(axis)[site];
    const double before = x;
    x = before + step;
    const double plus = system.stored_energy(state.x).elastic;
    x = before - step;
    const double minus = system.stored_energy(state.x).elastic;
    x = before;
    EXPECT_NEAR(force.axis(axis)[site], (minus - plus) / (2 * step), 1e-6 * largest);
  }
}

TEST_P(Law, TangentEqualsDifferencesOfTheForce) {
  BodyConfig config = fem_config(VoxelGrid::box(2, 1, 2));
  config.damping = {.law = Damping::Law::viscosity, .viscosity = 200};
  const Body body(config);
  FemSystem system(body, {}, law());
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.15, 0.5, 11);
  const auto tangent = [&](const TangentCoefficients& sum) -> Eigen::MatrixXd {
    SparseMatrix matrix = system.tangents()->pattern();
    system.tangents()->values(0, state.x, state.v, sum, matrix);
    return matrix;
  };
  const double h = body.config().cell_size;
  EXPECT_LT(testing::relative_difference(tangent({.stiffness = 1, .kind = Tangent::exact}),
                                         testing::force_differences(system, state, true, h)),
            1e-6);
  EXPECT_LT(testing::relative_difference(tangent({.damping = 1, .kind = Tangent::exact}),
                                         testing::force_differences(system, state, false, h)),
            1e-6);
  for (const auto kind : {Tangent::elastic, Tangent::projected}) {
    const TangentCoefficients sum{.mass = 2, .damping = 0.3, .stiffness = 5, .kind = kind};
    const Eigen::MatrixXd matrix = tangent(sum);
    EXPECT_LT(testing::relative_difference(matrix, matrix.transpose()), 1e-12);
    Field<double> direction(system.size()), product(system.size());
    const auto& unknowns = system.tangents()->unknowns();
    Eigen::VectorXd p = Eigen::VectorXd::LinSpaced(matrix.rows(), -1, 2), ap(matrix.rows());
    for (std::size_t i = 0; i < unknowns.size(); ++i)
      direction.axis(unknowns[i].axis)[unknowns[i].site] = p[Eigen::Index(i)];
    system.tangents()->product(0, state.x, state.v, sum, direction, product);
    for (std::size_t i = 0; i < unknowns.size(); ++i)
      ap[Eigen::Index(i)] = product.axis(unknowns[i].axis)[unknowns[i].site];
    EXPECT_LT(testing::relative_difference(ap, matrix * p), 1e-12);
    std::vector<Matrix3d> blocks;
    system.tangents()->diagonal(0, state.x, state.v, sum, blocks);
    for (std::size_t b = 0; b < blocks.size(); ++b)
      EXPECT_LT((blocks[b] - matrix.block<3, 3>(3 * Eigen::Index(b), 3 * Eigen::Index(b))).norm(),
                1e-12 * matrix.norm());
  }
}

// Boundary particles are moved by an affine map; the others must follow it.
TEST_P(Law, PassesThePatchTest) {
  const Body body(fem_config(VoxelGrid::box(4, 3, 3)));
  const double h = body.config().cell_size;
  const Vec3 low = body.config().origin + Vec3::Constant(0.5 * h),
             high = body.config().origin + h * Vec3(3.5, 2.5, 2.5);
  Matrix3d map;
  map << 1.02, 0.03, -0.01, 0.01, 0.99, 0.02, 0.015, -0.02, 1.01;
  // The holds are one box per particle of the boundary.
  Environment environment;
  for (const std::ptrdiff_t site : body.sites()) {
    const Vec3 rest = body.rest_position(site);
    if ((rest.array() > low.array()).all() && (rest.array() < high.array()).all()) continue;
    environment.holds.push_back({.box = {rest, rest}, .displacement = map * rest - rest});
  }
  FemSystem system(body, environment, law());
  ASSERT_EQ(system.tangents()->unknowns().size(), 3U * 3 * 2 * 2);
  State<double> state = system.rest_state();
  Work work;
  const auto method = find_integrator("static").make<double>({.tolerance = 1e-12});
  ASSERT_EQ(method->advance(system, state, 1, work), Status::ok);
  for (const std::ptrdiff_t site : body.sites())
    EXPECT_LT((state.x.at(site) - map * body.rest_position(site)).norm(), 1e-10 * h);
}

TEST_P(Law, ForcesAreTheSameForAnyNumberOfThreads) {
  const Body body(fem_config(VoxelGrid::box(5, 4, 3), 0.1));
  FemSystem one(body, {}, law(), 1), three(body, {}, law(), 3);
  State<double> state = one.rest_state();
  testing::randomise(body, state, 0.2, 0.5, 7);
  Field<double> a(one.size()), b(one.size());
  one.force(0, state.x, state.v, a);
  three.force(0, state.x, state.v, b);
  EXPECT_TRUE((a.array() == b.array()).all());
}

// Irons and Treharne: the bound is above the fastest mode, and not far above.
TEST_P(Law, BoundsItsFrequencies) {
  const Body body(fem_config(VoxelGrid::box(3, 3, 3)));
  FemSystem system(body, {}, law());
  const State<double> rest = system.rest_state();
  SparseMatrix k = system.tangents()->pattern(), m = k;
  system.tangents()->values(0, rest.x, rest.v, {.stiffness = 1, .kind = Tangent::elastic}, k);
  system.tangents()->values(0, rest.x, rest.v, {.mass = 1}, m);
  const double fastest = std::sqrt(testing::symmetric_eigenvalues(k, m).maxCoeff());
  EXPECT_GE(system.spectral_bound().omega, fastest * (1 - 1e-12));
  EXPECT_LT(system.spectral_bound().omega, 1.3 * fastest);
}

TEST_P(Law, KeepsItsEnergyUnderVelocityVerlet) {
  const Body body(fem_config(VoxelGrid::box(2, 2, 2)));
  FemSystem system(body, {}, law());
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : body.sites()) state.x.axis(2)[site] *= 1.05;
  const double before = measure(system, state).total();
  Work work;
  const double dt = 0.2 / system.spectral_bound().omega;
  ASSERT_EQ(
      find_integrator("velocity_verlet").make<double>({.dt = dt})->advance(system, state, 2000 * dt, work),
      Status::ok);
  EXPECT_NEAR(measure(system, state).total() / before, 1, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Registry, Law, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const SolidLaw& l : solid_laws()) names.push_back(l.name);
                           return names;
                         }()),
                         [](const auto& param) { return param.param; });

/// A bar of 1 x 1 x 3 cells whose particles start turned about its axis, by a right angle at its top.
State<double> twisted(const BodySystem<double>& system) {
  State<double> state = system.rest_state();
  const BodyConfig& config = system.body().config();
  const double height = 3 * config.cell_size;
  const Vec3 axis = config.origin + Vec3(0.5, 0.5, 0) * config.cell_size;
  for (const std::ptrdiff_t site : system.body().sites()) {
    const Vec3 arm = state.x.at(site) - axis;
    const double angle = std::numbers::pi / 2 * arm[2] / height;
    state.x.set(site, axis + Eigen::AngleAxisd(angle, Vec3::UnitZ()) * arm);
  }
  return state;
}

TEST(Corotational, ReturnsToRestAfterATwistByARightAngle) {
  const Body body(fem_config(VoxelGrid::box(1, 1, 3), 0.3));
  const Vec3 low = body.config().origin;
  const double h = body.config().cell_size;
  FemSystem system(body, {.holds = {{.box = {low, low + Vec3(h, h, 0)}}}}, [] {
    for (const SolidLaw& l : solid_laws())
      if (l.name == "corotational") return l;
    throw std::logic_error("no such law");
  }());
  State<double> state = twisted(system);
  const State<double> rest = system.rest_state();
  Work work;
  const double dt = 0.5 / (system.spectral_bound().omega + system.spectral_bound().damping);
  double start = 0, end = 0;
  for (const std::ptrdiff_t site : body.sites())
    start = std::max(start, (state.x.at(site) - rest.x.at(site)).norm());
  ASSERT_EQ(
      find_integrator("damped_verlet").make<double>({.dt = dt})->advance(system, state, 40000 * dt, work),
      Status::ok);
  for (const std::ptrdiff_t site : body.sites())
    end = std::max(end, (state.x.at(site) - rest.x.at(site)).norm());
  EXPECT_GT(start, 0.5 * h);
  EXPECT_LT(end, 1e-8 * h);
}

TEST(FemSystem, IsDrivenByEveryIntegrator) {
  const Body body(fem_config(VoxelGrid::box(2, 2, 2), 0.1));
  const Vec3 low = body.config().origin;
  const Environment environment{.gravity = Vec3(0, 0, -9.81),
                                .holds = {{.box = {low, low + Vec3(0.4, 0.4, 0)}}}};
  for (const SolidLaw& law : solid_laws()) {
    SCOPED_TRACE(law.name);
    FemSystem system(body, environment, law);
    testing::expect_driven_by_every_integrator(system);
  }
}

// The law of the springs' dampers: 2 eta e + eta tr(e) I, and no less a bound of its rates.
TEST(FemSystem, TakesAViscosity) {
  const double eta = 40;
  BodyConfig config = fem_config(VoxelGrid::box(2, 1, 3));
  config.damping = {.law = Damping::Law::viscosity, .viscosity = eta};
  const Body body(config);
  Eigen::Matrix3d rate;
  rate << 0.3, 0.7, -0.2, -0.1, -0.4, 0.5, 0.6, 0.2, 0.9;
  const Eigen::Matrix3d e = (rate + rate.transpose()) / 2;
  const double density = 2 * eta * e.squaredNorm() + eta * e.trace() * e.trace();
  for (const SolidLaw& law : solid_laws()) {
    FemSystem system(body, {}, law);
    State<double> state = system.rest_state();
    double mass_weighted = 0;
    for (const std::ptrdiff_t site : body.sites()) {
      state.v.set(site, rate * state.x.at(site));
      mass_weighted += body.mass(site) * state.v.at(site).squaredNorm();
    }
    Field<double> force(system.size());
    system.force(0, state.x, state.v, force);
    double power = 0;
    for (const std::ptrdiff_t site : body.sites()) power -= force.at(site).dot(state.v.at(site));
    EXPECT_NEAR(power, 6 * body.cell_volume() * density, 1e-10 * power) << law.name;
    EXPECT_LT(power / mass_weighted, system.spectral_bound().damping) << law.name;
  }
}

/// Two parts in random fills.
BodyConfig mixed_fem_config(const VoxelGrid& voxels) {
  BodyConfig config = fem_config(voxels);
  const ElasticConstants other{.young = 5e4, .poisson = 0.2};
  config.parts = {{.density = 2000,
                   .springs = calibrate(other, config.cell_size, 0.5),
                   .elastic = other,
                   .damping = {.law = Damping::Law::viscosity, .viscosity = 200}}};
  testing::fill_randomly(config, 4);
  return config;
}

// A cell's force is that of full cells of its parts, by their shares.
TEST(FemSystem, TakesFillFactorsAndParts) {
  for (const SolidLaw& law : solid_laws()) {
    BodyConfig config = mixed_fem_config(VoxelGrid::box(1, 1, 1));
    for (const CellContent& content : config.contents) {
      Field<double> sum;
      const auto force_of = [&](const CellContent& of_cell) {
        config.content_of = {0};
        BodyConfig one = config;
        one.contents = {of_cell};
        const Body body(one);
        FemSystem system(body, {}, law);
        State<double> state = system.rest_state();
        testing::randomise(body, state, 0.15, 0.5, 7);
        Field<double> force(system.size());
        system.force(0, state.x, state.v, force);
        return force;
      };
      const Field<double> force = force_of(content);
      sum = force;
      for (const auto& [part, fill] : content)
        sum.array() -= double(fill.share()) * force_of({{part, CellFill::even(1)}}).array();
      EXPECT_LT(sum.array().abs().maxCoeff(), 1e-14 * force.array().abs().maxCoeff()) << law.name;
    }
    const Body body(mixed_fem_config(VoxelGrid::box(3, 2, 3)));
    FemSystem system(body, {}, law);
    const State<double> rest = system.rest_state();
    Work work;
    const double fastest = fastest_mode(system, rest, work).modes.front().omega;
    EXPECT_GE(system.spectral_bound().omega, fastest * (1 - 1e-9)) << law.name;
    EXPECT_LT(system.spectral_bound().omega, 3 * fastest) << law.name;
  }
}

TEST(FemSystem, NeedsAMaterial) {
  BodyConfig config = fem_config(VoxelGrid::box(1, 1, 1));
  config.elastic.reset();
  const Body body(config);
  EXPECT_THROW(FemSystem(body, {}, solid_laws().front()), InputError);
}

}  // namespace
}  // namespace mss
