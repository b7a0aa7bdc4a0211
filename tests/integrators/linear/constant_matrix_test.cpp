// The constant matrix of the linear solver `separable`: eigenvectors solve it, it bounds the tangent, and
// what has none along the axes is refused.
#include "integrators/linear/constant_matrix.hpp"

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <cstring>

#include "core/base/error.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "integrators/linear/unknowns.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

enum Face { x_low, x_high, y_low, y_high, z_low, z_high };

/// A hold of a whole face.
Hold face(const Body& body, Face which, std::array<bool, 3> axes = {true, true, true}) {
  const VoxelGrid& voxels = body.config().voxels;
  const Vec3 low = body.config().origin;
  Box box{low, low + body.config().cell_size * Vec3(voxels.nx(), voxels.ny(), voxels.nz())};
  const int axis = which / 2;
  (which % 2 == 0 ? box.upper : box.lower)[axis] = (which % 2 == 0 ? box.lower : box.upper)[axis];
  return {.box = box, .axes = axes};
}

Field<double> random_field(const Body& body, unsigned seed) {
  Field<double> field(body.lattice().size);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<> u(-1, 1);
  for (const std::ptrdiff_t site : body.sites()) field.set(site, Vec3(u(rng), u(rng), u(rng)));
  return field;
}

Field<double> solution_of(ConstantSolver& solver, System<double>& system, const ConstantMatrix& matrix,
                          const Field<double>& rhs) {
  Field<double> solution(system.size());
  EXPECT_EQ(solver.prepare(matrix), Status::ok);
  solver.solve(system, rhs, solution);
  return solution;
}

/// The matrix as it is defined, for the coordinates along an axis that nothing prescribes.
class PlainSolver {
 public:
  PlainSolver(const Body& body, System<double>& system) : body_(body), mask_(mask_of_unknowns(system)) {}

  Field<double> solve(const ConstantMatrix& matrix, const Field<double>& rhs) const {
    Field<double> solution(body_.lattice().size);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(assemble(matrix, axis));
      Eigen::VectorXd x = Eigen::VectorXd::Zero(Eigen::Index(body_.particle_count()));
      for (std::size_t p = 0; p < body_.particle_count(); ++p)
        x[Eigen::Index(p)] = is_free(p, axis) ? rhs.axis(axis)[body_.sites()[p]] : 0;
      x = factor.solve(x).eval();
      for (std::size_t p = 0; p < body_.particle_count(); ++p)
        solution.axis(axis)[body_.sites()[p]] = x[Eigen::Index(p)];
    }
    return solution;
  }

 private:
  bool is_free(std::size_t p, int axis) const { return mask_.axis(axis)[body_.sites()[p]] != 0; }

  Eigen::SparseMatrix<double> assemble(const ConstantMatrix& matrix, int axis) const {
    std::vector<Eigen::Triplet<double>> entries;
    const auto join = [&](std::ptrdiff_t a, std::ptrdiff_t b, double weight) {
      const int one = body_.particle(a), two = body_.particle(b);
      const bool first = is_free(std::size_t(one), axis), second = is_free(std::size_t(two), axis);
      if (first) entries.emplace_back(one, one, weight);
      if (second) entries.emplace_back(two, two, weight);
      if (!first || !second) return;
      entries.emplace_back(one, two, -weight);
      entries.emplace_back(two, one, -weight);
    };
    constexpr std::array<std::size_t, 3> slot_of_class{0, 3, 9};
    body_.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double k, double) {
      const auto kind = std::size_t(slot.kind);
      join(a, b, matrix.spring[kind] * k / body_.kinds().interior_stiffness(slot_of_class[kind]));
    });
    body_.for_each_cell([&](std::ptrdiff_t site) {
      const double weight = matrix.cell_edge * body_.weights_at(site).volume;
      for (int c = 0; c < 8; ++c)
        for (const int step : {1, 2, 4})
          if ((c & step) == 0)
            join(site + body_.lattice().corner(c), site + body_.lattice().corner(c | step), weight);
    });
    for (std::size_t p = 0; p < body_.particle_count(); ++p)
      entries.emplace_back(int(p), int(p), is_free(p, axis) ? matrix.mass * body_.mass(body_.sites()[p]) : 1);
    const auto rows = Eigen::Index(body_.particle_count());
    Eigen::SparseMatrix<double> assembled(rows, rows);
    assembled.setFromTriplets(entries.begin(), entries.end());
    return assembled;
  }

  const Body& body_;
  Field<double> mask_;
};

double largest(const Field<double>& field) { return field.array().abs().maxCoeff(); }

struct MatrixCase {
  std::string name;
  std::array<int, 3> cells;
  std::vector<std::pair<Face, std::array<bool, 3>>> faces;
  Topology topology = Topology::full;
};

constexpr std::array<bool, 3> xyz{true, true, true};

class Separable : public ::testing::TestWithParam<MatrixCase> {};

TEST_P(Separable, SolvesTheMatrix) {
  const auto [nx, ny, nz] = GetParam().cells;
  BodyConfig config = testing::test_config(VoxelGrid::box(nx, ny, nz));
  config.topology = GetParam().topology;
  const Body body(config);
  Environment environment;
  for (const auto& [which, axes] : GetParam().faces) environment.holds.push_back(face(body, which, axes));
  SpringSystem<double> system(body, environment);
  const auto separable = separable_solver(body, system);
  const PlainSolver plain(body, system);
  const Field<double> rhs = random_field(body, 5);
  for (const double dt : {1e-3, 0.03, 0.5}) {
    const ConstantMatrix matrix = bounding_matrix(body, 1, dt, dt * dt);
    const Field<double> one = solution_of(*separable, system, matrix, rhs), other = plain.solve(matrix, rhs);
    EXPECT_LE((one.array() - other.array()).abs().maxCoeff(), 1e-12 * largest(other)) << dt;
    Field<double> held = one;
    system.clear_prescribed(held);
    EXPECT_EQ(std::memcmp(held.axis(0), one.axis(0), std::size_t(one.size()) * sizeof(double)), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Boxes, Separable,
    ::testing::Values(
        MatrixCase{"cell", {1, 1, 1}, {}}, MatrixCase{"free", {3, 4, 5}, {}},
        MatrixCase{"cube_held_below", {7, 7, 7}, {{z_low, xyz}}},
        MatrixCase{"beam_between_walls", {26, 3, 4}, {{x_low, xyz}, {x_high, xyz}}},
        MatrixCase{"plate", {9, 2, 50}, {{y_high, xyz}}},
        MatrixCase{"rollers", {5, 6, 7}, {{x_low, {true, false, false}}, {z_high, {false, true, true}}}},
        MatrixCase{"nothing_free", {4, 1, 4}, {{y_low, xyz}, {y_high, xyz}}},
        MatrixCase{"without_faces", {8, 8, 8}, {{x_low, xyz}}, Topology::edges_body}),
    [](const auto& p) { return p.param.name; });

TEST(ConstantMatrix, IsAtLeastTheTangent) {
  for (const auto& [name, voxels] : testing::test_shapes())
    for (const bool mixed : {false, true}) {
      BodyConfig config = mixed ? testing::mixed_config(voxels, 2) : testing::test_config(voxels);
      // Of a ratio springs that no other cell shares may damp more.
      config.damping = {.law = Damping::Law::viscosity, .viscosity = 20};
      for (Part& part : config.parts) part.damping = {.law = Damping::Law::viscosity, .viscosity = 50};
      const Body body(config);
      SpringSystem<double> system(body, {});
      State<double> state = system.rest_state();
      testing::randomise(body, state, 0.1, 0, 4);
      const double dt = 0.1;
      const Field<double> rhs = random_field(body, 9);
      const Field<double> p = PlainSolver(body, system).solve(bounding_matrix(body, 1, dt, dt * dt), rhs);
      Field<double> image(system.size());
      const TangentCoefficients sum{
          .mass = 1, .damping = dt, .stiffness = dt * dt, .kind = Tangent::projected};
      system.tangents()->product(0, state.x, state.v, sum, p, image);
      const double bound = (p.array() * rhs.array()).sum(), value = (p.array() * image.array()).sum();
      EXPECT_LT(value, bound) << name << mixed;
      EXPECT_GT(value, 0.05 * bound) << name << mixed;
    }
}

// The sum of forces on a free body's particles changes its momentum alone: 1^T A = 1^T M.
TEST(ConstantMatrix, KeepsMomentum) {
  const Body body(testing::test_config(VoxelGrid::box(6, 5, 4)));
  SpringSystem<double> system(body, {});
  const auto solver = separable_solver(body, system);
  const Field<double> rhs = random_field(body, 2);
  const Field<double> y = solution_of(*solver, system, bounding_matrix(body, 1, 1, 10), rhs);
  Vec3 momentum = Vec3::Zero(), given = Vec3::Zero();
  for (const std::ptrdiff_t site : body.sites()) {
    momentum += body.mass(site) * y.at(site);
    given += rhs.at(site);
  }
  EXPECT_LT((momentum - given).norm(), 1e-12 * std::sqrt(double(body.particle_count())));
}

TEST(ConstantMatrix, GivesTheSameBitsForAnyNumberOfThreads) {
  const Body body(testing::test_config(VoxelGrid::box(11, 12, 13)));
  const Field<double> rhs = random_field(body, 3);
  const auto solve = [&](int threads) {
    SpringSystem<double> system(body, {}, {.threads = threads});
    return solution_of(*separable_solver(body, system), system, bounding_matrix(body, 1, 0, 1), rhs);
  };
  const Field<double> one = solve(1);
  for (const int threads : {2, 3, 5}) {
    const Field<double> other = solve(threads);
    EXPECT_EQ(std::memcmp(one.axis(0), other.axis(0), std::size_t(one.size()) * sizeof(double)), 0)
        << threads;
  }
}

TEST(ConstantMatrix, WithoutMassABodyMustBeHeld) {
  const Body body(testing::test_config(VoxelGrid::box(3, 3, 3)));
  SpringSystem<double> loose(body, {}), held(body, {.holds = {face(body, x_low)}});
  EXPECT_EQ(separable_solver(body, loose)->prepare(bounding_matrix(body, 0, 0, 1)),
            Status::not_positive_definite);
  EXPECT_EQ(separable_solver(body, held)->prepare(bounding_matrix(body, 0, 0, 1)), Status::ok);
}

std::string refusal(const BodyConfig& config, const std::vector<Hold>& holds = {}) {
  const Body body(config);
  SpringSystem<double> system(body, {.holds = holds});
  try {
    separable_solver(body, system);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// As a linear solver: a third of block-Jacobi's iterations on a long step.
TEST(ConstantMatrix, PreconditionsTheTangent) {
  const Body body(testing::test_config(VoxelGrid::box(12, 12, 12)));
  SpringSystem<double> system(body, {.holds = {face(body, x_low)}});
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.05, 0.5, 5);
  const double dt = 300 / system.spectral_bound().omega;
  const TangentCoefficients sum{.mass = 1, .damping = dt, .stiffness = dt * dt, .kind = Tangent::projected};
  const Field<double> rhs = random_field(body, 7);
  const auto products = [&](const char* name) {
    const auto solver = find_linear_solver(name).make(1e-6);
    Field<double> solution(system.size());
    Work work;
    EXPECT_EQ(solver->prepare(system, 0, state.x, state.v, sum, work), Status::ok);
    EXPECT_EQ(solver->solve(rhs, solution, work), Status::ok);
    return work.products;
  };
  EXPECT_LT(3 * products("separable"), products("matrix_free"));
}

TEST(ConstantMatrix, RefusesInWordsWhatItCannotDo) {
  const BodyConfig box = testing::test_config(VoxelGrid::box(3, 3, 3));
  EXPECT_EQ(refusal(box), "");
  BodyConfig other = box;
  other.voxels.set(2, 2, 2, false);
  EXPECT_EQ(refusal(other),
            "separable is for boxes, and 1 of the 27 cells of this body's are empty; cholmod takes any body");
  other = box;
  other.sharing = Sharing::uniform;
  EXPECT_NE(refusal(other).find("\"uniform\""), std::string::npos);
  other = box;
  other.topology = Topology::one_diagonal;
  EXPECT_NE(refusal(other).find("\"one_diagonal\""), std::string::npos);
  other = box;
  other.weights = {{.box = {box.origin, box.origin}, .mass = 1}};
  EXPECT_NE(refusal(other).find("weights"), std::string::npos);
  other = box;
  testing::fill_evenly(other, std::vector<float>(27, 0.5F));
  EXPECT_NE(refusal(other).find("fill factors"), std::string::npos);
  const Vec3 low = box.origin;
  EXPECT_NE(refusal(box, {{.box = {low, low + Vec3(0.6, 0.4, 0)}, .axes = {false, true, true}}})
                .find("the hold of y takes a part"),
            std::string::npos);
}

}  // namespace
}  // namespace mss
