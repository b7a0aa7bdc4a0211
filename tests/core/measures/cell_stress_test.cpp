// Stress of cells: against energies of homogeneous deformations, Hooke's law, weights that hang below,
// tractions, a beam's closed form and the forces that cells add up to.
#include "core/measures/cell_stress.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <utility>

#include "core/body/cell_springs.hpp"
#include "core/forces/cell_geometry.hpp"
#include "core/refinement/refined_system.hpp"
#include "experiments/simulation/uniform_stress.hpp"
#include "integrators/integrator.hpp"
#include "reference/fem/fem_system.hpp"
#include "reference/large_strain.hpp"
#include "reference/mollemans.hpp"
#include "tests/differences.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

using Eigen::Matrix3d;
using reference::CauchyBorn;

constexpr ElasticConstants rubber{.young = 1e5, .poisson = 0.3};

BodyConfig block(const VoxelGrid& voxels, double cell_size = 0.25, double face_share = 0.5,
                 const ElasticConstants& material = rubber) {
  BodyConfig config{.voxels = voxels, .cell_size = cell_size};
  config.fill(material, face_share);
  return config;
}

Matrix3d matrix(std::initializer_list<double> rows) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.begin());
}

/// The rest state mapped by F, with velocities L x.
State<double> mapped(const SolidSystem<double>& system, const Matrix3d& F,
                     const Matrix3d& L = Matrix3d::Zero()) {
  State<double> state = system.undeformed_state();
  for (const Level& level : system.levels())
    for (std::ptrdiff_t site = 0; site < level.body.lattice().sites; ++site) {
      const Vec3 x = F * level.body.rest_position(site);
      state.x.set(level.first + site, x);
      state.v.set(level.first + site, L * x);
    }
  return state;
}

Matrix3d cauchy(const reference::LargeStrainLaw& law, const Matrix3d& F) {
  return law.stress(F) * F.transpose() / F.determinant();
}

/// Calls visit(site, stress) for the cells of a body of one level.
template <class Visit>
void for_each_stress(const BodySystem<double>& system, const State<double>& state, Visit&& visit) {
  const CellStress stress = cell_stress(system, state);
  ASSERT_TRUE(stress);
  ASSERT_EQ(stress->size(), system.body().cell_count());
  auto next = stress->begin();
  system.body().for_each_cell([&](std::ptrdiff_t site) { visit(site, *next++); });
}

/// Largest difference of the cells' stresses from one, over its norm.
double largest_error(const BodySystem<double>& system, const State<double>& state, const Matrix3d& expected) {
  double error = 0;
  for_each_stress(system, state, [&](std::ptrdiff_t, const Matrix3d& stress) {
    error = std::max(error, (stress - expected).norm() / expected.norm());
  });
  return error;
}

Matrix3d uniaxial() { return Vec3(1.2, 1, 1).asDiagonal(); }
Matrix3d simple_shear() { return matrix({1, 0.3, 0, 0, 1, 0, 0, 0, 1}); }
Matrix3d compression() { return 0.9 * Matrix3d::Identity(); }
Matrix3d general() { return matrix({1.3, 0.2, -0.1, -0.3, 0.8, 0.15, 0.1, 0.05, 1.1}); }

// ---- What a cell has of its springs ----

/// Stiffness and damping of the body's springs by their ends.
using Springs = std::map<std::pair<std::ptrdiff_t, std::ptrdiff_t>, std::pair<double, double>>;

void add_to(Springs& springs, std::ptrdiff_t a, std::ptrdiff_t b, double stiffness, double damping) {
  auto& [k, c] = springs[std::minmax(a, b)];
  k += stiffness;
  c += damping;
}

/// Largest difference of what cells have together from the body's springs, over the largest of these.
double shares_error(const BodyConfig& config) {
  const Body body(config);
  Springs whole, shared;
  body.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot&, double k, double c) {
    add_to(whole, a, b, k, c);
  });
  CellSprings springs(body);
  body.for_each_cell([&](std::ptrdiff_t site) {
    for (const CellSpring& spring : springs.at(site))
      if (spring.stiffness != 0)
        add_to(shared, site + body.lattice().corner(spring.a), site + body.lattice().corner(spring.b),
               spring.stiffness, spring.damping);
  });
  EXPECT_EQ(whole.size(), shared.size());
  double error = 0, largest_k = 0, largest_c = 1e-300;
  for (const auto& [ends, spring] : whole) {
    largest_k = std::max(largest_k, std::abs(spring.first));
    largest_c = std::max(largest_c, std::abs(spring.second));
  }
  for (const auto& [ends, spring] : whole)
    error = std::max({error, std::abs(shared[ends].first - spring.first) / largest_k,
                      std::abs(shared[ends].second - spring.second) / largest_c});
  return error;
}

TEST(CellSprings, AddUpToTheBodys) {
  unsigned seed = 0;
  for (const auto& shape : testing::test_shapes())
    for (const auto topology : {Topology::full, Topology::edges_body, Topology::one_diagonal}) {
      BodyConfig config = testing::test_config(shape.voxels);
      config.topology = topology;
      for (const auto sharing : {Sharing::weighted, Sharing::uniform}) {
        config.sharing = sharing;
        EXPECT_LT(shares_error(config), 1e-14) << shape.name;
      }
      BodyConfig mixed = testing::mixed_config(shape.voxels, ++seed);
      mixed.topology = topology;
      EXPECT_LT(shares_error(mixed), 1e-14) << shape.name;
      mixed.damping = mixed.parts[0].damping = mixed.parts[1].damping = {};
      EXPECT_LT(shares_error(mixed), 1e-14) << shape.name;
    }
}

// ---- Homogeneous deformations ----

TEST(CellStress, OfHomogeneousDeformationsIsTheEnergysDerivativeInEveryCell) {
  for (const auto& shape : testing::test_shapes())
    for (const double poisson : {0.1, 0.25, 0.45}) {
      const ElasticConstants material{.young = 1e5, .poisson = poisson};
      const Body body(block(shape.voxels, 0.25, 0.5, material));
      const SpringSystem<double> system(body, {});
      const CauchyBorn law(body.config().springs, 0.25);
      for (const Matrix3d& F : {uniaxial(), simple_shear(), compression(), general()})
        EXPECT_LT(largest_error(system, mapped(system, F), cauchy(law, F)), 1e-12) << shape.name;
    }
}

TEST(CellStress, OfRandomFillsIsThatOfTheMaterial) {
  BodyConfig config = block(VoxelGrid::box(5, 4, 3));
  testing::fill_randomly(config, 4);
  const Body body(config);
  const SpringSystem<double> system(body, {});
  const CauchyBorn law(config.springs, config.cell_size);
  for (const Matrix3d& F : {uniaxial(), simple_shear(), compression(), general()})
    EXPECT_LT(largest_error(system, mapped(system, F), cauchy(law, F)), 1e-12);
}

TEST(CellStress, OfPartsThatShareSpringsIsEachOnesOwn) {
  BodyConfig config = testing::test_config(VoxelGrid::box(4, 3, 3));
  config.damping = {};
  testing::add_parts(config);
  for (int part = 0; part < 3; ++part) config.contents.push_back({{part, CellFill::even(1)}});
  for (std::uint32_t cell = 0; cell < 36; ++cell) config.content_of.push_back(cell % 7 % 3);
  const Body body(config);
  const SpringSystem<double> system(body, {});
  const State<double> state = mapped(system, general());
  for_each_stress(system, state, [&](std::ptrdiff_t site, const Matrix3d& stress) {
    const auto part = std::size_t(body.content_at(site)[0].part);
    const Matrix3d expected = cauchy(CauchyBorn(body.parts()[part].springs, config.cell_size), general());
    EXPECT_LT((stress - expected).norm(), 1e-12 * expected.norm()) << part;
  });
}

/// The odd part of the stress at two opposite strains: what is linear in them, to second order.
double hooke_error(BodySystem<double>& system, const Matrix3d& strain) {
  const auto [young, poisson] = rubber;
  const double mu = young / (2 * (1 + poisson)), lambda = 2 * mu * poisson / (1 - 2 * poisson);
  const Matrix3d expected = 2 * mu * strain + lambda * strain.trace() * Matrix3d::Identity();
  const CellStress more = cell_stress(system, mapped(system, Matrix3d::Identity() + strain)),
                   less = cell_stress(system, mapped(system, Matrix3d::Identity() - strain));
  double error = 0;
  for (std::size_t cell = 0; cell < more->size(); ++cell)
    error = std::max(error, (((*more)[cell] - (*less)[cell]) / 2 - expected).norm() / expected.norm());
  return error;
}

TEST(CellStress, OfSmallStrainsIsHookes) {
  constexpr double strain = 1e-5;
  const Body body(block(VoxelGrid::box(3, 2, 2)));
  SpringSystem<double> springs(body, {});
  for (const Matrix3d& unit :
       {matrix({1, 0, 0, 0, 0, 0, 0, 0, 0}), matrix({0, 1, 0, 1, 0, 0, 0, 0, 0}),
        Matrix3d(Matrix3d::Identity()), matrix({0.3, 0.5, -0.2, 0.5, -0.7, 0.4, -0.2, 0.4, 0.9})}) {
    EXPECT_LT(hooke_error(springs, strain * unit), 1e-9);
    for (const SolidLaw& law : solid_laws()) {
      FemSystem elements(body, {}, law);
      EXPECT_LT(hooke_error(elements, strain * unit), 1e-9) << law.name;
    }
  }
  MollemansSystem tetrahedra(body, {});
  EXPECT_LT(hooke_error(tetrahedra, strain * Matrix3d::Identity()), 1e-9);
}

TEST(CellStress, OfElementsIsTheLaws) {
  const Body body(block(VoxelGrid::box(3, 2, 2)));
  const reference::StVenantKirchhoff expected(rubber);
  const auto law = std::find_if(solid_laws().begin(), solid_laws().end(),
                                [](const SolidLaw& l) { return l.name == "st_venant_kirchhoff"; });
  ASSERT_NE(law, solid_laws().end());
  const FemSystem system(body, {}, *law);
  EXPECT_LT(largest_error(system, mapped(system, general()), cauchy(expected, general())), 1e-12);
}

// Springs of calibrated bodies have the bulk viscosity 5/3 eta, see Damping.
TEST(CellStress, OfStrainRatesIsKelvinAndVoigts) {
  constexpr double eta = 40;
  BodyConfig config = block(VoxelGrid::box(4, 3, 2));
  config.damping = {.law = Damping::Law::viscosity, .viscosity = eta};
  const Body body(config);
  const Matrix3d L = matrix({0.3, 0.7, -0.2, 0.1, -0.5, 0.4, 0, 0.6, 0.9});
  const Matrix3d rate = (L + L.transpose()) / 2;
  const Matrix3d expected = 2 * eta * rate + eta * rate.trace() * Matrix3d::Identity();
  const SpringSystem<double> springs(body, {});
  EXPECT_LT(largest_error(springs, mapped(springs, Matrix3d::Identity(), L), expected), 1e-12);
  for (const SolidLaw& law : solid_laws()) {
    const FemSystem elements(body, {}, law);
    EXPECT_LT(largest_error(elements, mapped(elements, Matrix3d::Identity(), L), expected), 1e-12);
  }
}

// ---- Any deformation ----

/// Sum over cells of f V sigma.
Matrix3d sum_of_stress(const SolidSystem<double>& system, const State<double>& state) {
  const CellStress stress = cell_stress(system, state);
  Matrix3d sum = Matrix3d::Zero();
  auto next = stress->begin();
  for (const Level& level : system.levels())
    level.body.for_each_cell([&](std::ptrdiff_t site) {
      sum += level.body.weights_at(site).fill *
             trilinear_volume(corners_of(level.body, state.x, level.first + site)) * *next++;
    });
  return sum;
}

Matrix3d sum_of_forces(SolidSystem<double>& system, const State<double>& state) {
  Field<double> f(system.size());
  system.force(0, state.x, state.v, f);
  Matrix3d sum = Matrix3d::Zero();
  for (const std::ptrdiff_t site : system.particles()) sum -= f.at(site) * state.x.at(site).transpose();
  return sum;
}

/// How far the cells' virials are from that of the solid's forces in a random state.
double virial_error(SolidSystem<double>& system, unsigned seed) {
  State<double> state = system.rest_state();
  testing::randomise(system, state, 0.3, 0.5, seed);
  const Matrix3d expected = sum_of_forces(system, state);
  return (sum_of_stress(system, state) - expected).norm() / expected.norm();
}

const Environment weightless{.gravity = Vec3::Zero()};

TEST(CellStress, OfAllCellsIsTheVirialOfTheForces) {
  unsigned seed = 20;
  for (const auto& shape : testing::test_shapes())
    for (const double guard : {0.0, 20.0}) {
      BodyConfig config = testing::mixed_config(shape.voxels, ++seed);
      config.fold_guard = guard;
      const Body body(config);
      SpringSystem<double> system(body, weightless);
      EXPECT_LT(virial_error(system, seed), 1e-12) << shape.name;
      config.contents.clear(), config.content_of.clear();
      config.sharing = Sharing::uniform;
      const Body full(config);
      SpringSystem<double> uniform(full, weightless);
      EXPECT_LT(virial_error(uniform, seed), 1e-12) << shape.name;
    }
}

TEST(CellStress, OfAllElementsIsTheVirialOfTheForces) {
  BodyConfig config = block(VoxelGrid::box(4, 3, 2));
  config.damping = {.law = Damping::Law::viscosity, .viscosity = 40};
  const Body body(config);
  for (const SolidLaw& law : solid_laws()) {
    FemSystem system(body, weightless, law);
    State<double> state = system.rest_state();
    testing::randomise(system, state, 0.3, 0.5, 5);
    const Matrix3d virial = sum_of_forces(system, state);
    const Matrix3d expected = (virial + virial.transpose()) / 2;  // linear elements turn by forces
    EXPECT_LT((sum_of_stress(system, state) - expected).norm(), 1e-12 * expected.norm()) << law.name;
  }
}

TEST(CellStress, OfCellsOfSeveralSizes) {
  BodyConfig config = block(VoxelGrid::box(4, 3, 3));
  config.damping = {.law = Damping::Law::viscosity, .viscosity = 40};
  const std::vector<RefinedBox> boxes{{{Vec3::Zero(), Vec3::Constant(0.5)}, 2}};
  const RefinedBody body(config, refinement_of(config, boxes));
  ASSERT_EQ(body.levels().size(), 3U);
  RefinedSystem<double> system(body, weightless);
  EXPECT_LT(virial_error(system, 3), 1e-12);
  const Matrix3d expected = cauchy(CauchyBorn(config.springs, config.cell_size), general());
  const CellStress stress = cell_stress(system, mapped(system, general()));
  ASSERT_EQ(stress->size(), body.cell_count());
  for (const Matrix3d& of_cell : *stress) EXPECT_LT((of_cell - expected).norm(), 1e-12 * expected.norm());
}

TEST(CellStress, TurnsWithTheBody) {
  const Matrix3d R = Eigen::AngleAxisd(1.3, Vec3(1, -2, 3).normalized()).toRotationMatrix();
  BodyConfig config = testing::mixed_config(VoxelGrid::box(4, 3, 3), 8);
  config.fold_guard = 20;
  const Body body(config);
  const SpringSystem<double> system(body, {});
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.3, 0.5, 6);
  State<double> turned = state;
  for (const std::ptrdiff_t site : body.sites()) {
    turned.x.set(site, R * state.x.at(site) + Vec3(1, 2, 3));
    turned.v.set(site, R * state.v.at(site));
  }
  const CellStress before = cell_stress(system, state), after = cell_stress(system, turned);
  for (std::size_t cell = 0; cell < before->size(); ++cell) {
    EXPECT_LT(((*after)[cell] - R * (*before)[cell] * R.transpose()).norm(), 1e-11 * (*before)[cell].norm());
    EXPECT_EQ((*after)[cell], (*after)[cell].transpose());
  }
}

// ---- Equilibria ----

State<double> at_rest(SpringSystem<double>& system) {
  State<double> state = system.rest_state();
  Work work;
  EXPECT_EQ(find_integrator("static").make<double>({.tolerance = 1e-13})->advance(system, state, 1, work),
            Status::ok);
  return state;
}

/// By layer of cells along z: the force that goes through it, f V sigma_zz / dz added up, and the weight of
/// what hangs below the middle of its cells [N].
struct Section {
  double force = 0, weight = 0;
};
std::vector<Section> sections(const SpringSystem<double>& system, const State<double>& state) {
  const Body& body = system.body();
  std::vector<Section> layers(std::size_t(body.lattice().cells[2]));
  for_each_stress(system, state, [&](std::ptrdiff_t site, const Matrix3d& stress) {
    const std::array<Vec3, 8> corners = corners_of(body, state.x, site);
    layers[std::size_t(body.lattice().coordinates(site)[2])].force +=
        body.weights_at(site).fill * trilinear_volume(corners) * stress(2, 2) / mean_edges(corners)(2, 2);
  });
  for (const std::ptrdiff_t site : body.sites())
    for (int layer = 0; layer < int(layers.size()); ++layer)
      if (body.lattice().coordinates(site)[2] <= layer)
        layers[std::size_t(layer)].weight += 9.81 * body.mass(site);
  return layers;
}

/// Hung up at its upper end; in a smooth tube planes stay plane, whatever the strain.
Environment hanging(const BodyConfig& config, bool in_a_tube) {
  const Vec3 size = config.cell_size * Vec3(config.voxels.nx(), config.voxels.ny(), config.voxels.nz());
  Environment e{.gravity = Vec3(0, 0, -9.81), .holds = {{.box = {Vec3(0, 0, size[2]), size}}}};
  if (in_a_tube) e.holds.push_back({.box = {Vec3::Zero(), size}, .axes = {true, true, false}});
  return e;
}

double section_error(const BodyConfig& config, bool in_a_tube) {
  const Body body(config);
  SpringSystem<double> system(body, hanging(config, in_a_tube));
  const State<double> state = at_rest(system);
  double error = 0;
  for (const auto& [force, weight] : sections(system, state))
    error = std::max(error, std::abs(force / weight - 1));
  return error;
}

TEST(CellStress, OfAHangingBarIsTheWeightBelow) {
  const BodyConfig config = block(VoxelGrid::box(2, 2, 16));
  const Body body(config);
  SpringSystem<double> system(body, hanging(config, true));
  const State<double> state = at_rest(system);
  double largest = 0;
  for_each_stress(system, state, [&](std::ptrdiff_t site, const Matrix3d& stress) {
    const double middle = body.rest_position(site)[2] + config.cell_size / 2;
    const double expected = config.density * 9.81 * middle;
    EXPECT_NEAR(stress(2, 2), expected, 1e-9 * expected);
    largest = std::max(largest, state.x.at(site)[2] - body.rest_position(site)[2]);
  });
  EXPECT_LT(section_error(config, true), 1e-9);
}

TEST(CellStress, OfABarOfPartsAndPartlyFilledCellsCarriesTheWeightBelow) {
  BodyConfig config = block(VoxelGrid::box(3, 2, 8));
  config.parts = {{.name = "stiff", .density = 3000, .springs = calibrate({2e6, 0.2}, 0.25, 0.5)}};
  config.contents = {{{0, CellFill::even(1)}},
                     {{0, CellFill::even(0.4F)}},
                     {{1, CellFill::even(1)}},
                     {{0, CellFill::even(0.5F)}, {1, CellFill::even(0.25F)}}};
  for (std::uint32_t cell = 0; cell < 48; ++cell) config.content_of.push_back(cell / 6 % 4);  // layers
  EXPECT_LT(section_error(config, true), 1e-9);
}

// Its planes bulge by as much as it is strained, 1e-6.
TEST(CellStress, OfAFreeHangingBarCarriesTheWeightBelow) {
  EXPECT_LT(section_error(block(VoxelGrid::box(2, 2, 12), 0.25, 0.5, {.young = 2e10, .poisson = 0.3}), false),
            1e-5);
}

/// On a cube of 1 m, uniform tractions that add up to a nominal stress.
Environment pulled(const Matrix3d& nominal) {
  return {.gravity = Vec3::Zero(), .loads = uniform_stress(nominal).loads};
}

/// The lower faces stay in their planes.
std::vector<Hold> lower_faces() {
  return {{.box = {Vec3::Zero(), {0, 1, 1}}, .axes = {true, false, false}},
          {.box = {Vec3::Zero(), {1, 0, 1}}, .axes = {false, true, false}},
          {.box = {Vec3::Zero(), {1, 1, 0}}, .axes = {false, false, true}}};
}

/// Largest error of the cells' stress under the tractions of a deformation F that the holds admit.
double traction_error(const Matrix3d& F, const std::vector<Hold>& holds, double face_share) {
  const BodyConfig config = block(VoxelGrid::box(4, 4, 4), 0.25, face_share);
  const CauchyBorn law(config.springs, config.cell_size);
  const Body body(config);
  Environment environment = pulled(law.stress(F));
  environment.holds = holds;
  SpringSystem<double> system(body, environment);
  return largest_error(system, at_rest(system), cauchy(law, F));
}

// With body diagonals particles at the edges of a sheared cube err (core/refinement/README.md).
TEST(CellStress, OfUniformTractionsIsTheirs) {
  EXPECT_LT(traction_error(uniaxial(), lower_faces(), 0.5), 1e-9);
  EXPECT_LT(traction_error(0.97 * Matrix3d::Identity(), lower_faces(), 0.5), 1e-9);  // more makes it buckle
  EXPECT_LT(traction_error(simple_shear(), {{.box = {Vec3::Zero(), {1, 0, 1}}}}, 1), 1e-9);
}

/// Largest difference of sigma_xx of the cells in the middle of a cantilever of 8 x 1 x 1 m, m of them
/// across, from its closed form M z / I at their middles, over the largest of these.
double bending_error(int m) {
  const BodyConfig config = block(VoxelGrid::box(8 * m, m, m), 1.0 / m, 0.5, {.young = 1e8, .poisson = 0.3});
  const Body body(config);
  SpringSystem<double> system(body, {.gravity = Vec3::Zero(),
                                     .holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}},
                                     .loads = {{.box = {{8, 0, 0}, {8, 1, 1}}, .force = Vec3(0, 0, -1)}}});
  const State<double> state = at_rest(system);
  double error = 0, largest = 0;
  for_each_stress(system, state, [&](std::ptrdiff_t site, const Matrix3d& stress) {
    const Vec3 middle = body.rest_position(site) + Vec3::Constant(0.5 / m);
    if (std::abs(middle[0] - 4) > 1.0 / m) return;
    const double expected = (8 - middle[0]) * (middle[2] - 0.5) * 12;
    error = std::max(error, std::abs(stress(0, 0) - expected));
    largest = std::max(largest, std::abs(expected));
  });
  return error / largest;
}

TEST(CellStress, OfACantileverConvergesToTheClosedForm) {
  const double coarse = bending_error(2), fine = bending_error(4);
  EXPECT_LT(fine, 0.075);
  EXPECT_GT(coarse / fine, 3);
}

// ---- The rest ----

TEST(CellStress, InSinglePrecisionErrsByRounding) {
  const Body body(block(VoxelGrid::box(3, 2, 2)));
  const SpringSystem<double> system(body, {});
  const SpringSystem<float> single(body, {});
  const State<double> state = mapped(system, general());
  State<float> rounded = single.rest_state();
  for (const std::ptrdiff_t site : body.sites()) rounded.x.set(site, state.x.at(site));
  const Matrix3d expected = cauchy(CauchyBorn(body.config().springs, 0.25), general());
  const CellStress stress = cell_stress(single, rounded);
  for (const Matrix3d& of_cell : *stress) EXPECT_LT((of_cell - expected).norm(), 1e-5 * expected.norm());
}

TEST(CellStress, VonMises) {
  const Matrix3d R = Eigen::AngleAxisd(1.3, Vec3(1, -2, 3).normalized()).toRotationMatrix();
  const Matrix3d pull = Vec3(7, 0, 0).asDiagonal();
  EXPECT_NEAR(von_mises(pull), 7, 1e-14);
  EXPECT_NEAR(von_mises(R * pull * R.transpose() - 1e3 * Matrix3d::Identity()), 7, 1e-11);
  EXPECT_NEAR(von_mises(matrix({0, 2, 0, 2, 0, 0, 0, 0, 0})), 2 * std::sqrt(3), 1e-14);
}

/// A model that says no more than it must.
class Silent final : public BodySystem<double> {
 public:
  explicit Silent(const Body& body) : BodySystem<double>(body, {}, {}, 1) {}
  StoredEnergy stored_energy(const Field<double>&) const override { return {}; }
  const char* kernel_name() const override { return "none"; }
  void force(double, const Field<double>&, const Field<double>&, Field<double>& f) override { f.array() = 0; }
};

TEST(CellStress, IsNothingWhereTheModelDoesNotKnowIt) {
  const Body body(block(VoxelGrid::box(1, 1, 1)));
  const Silent system(body);
  EXPECT_FALSE(cell_stress(system, system.rest_state()));
}

}  // namespace
}  // namespace mss
