#include "integrators/reduction/reduced_shapes.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/environment/plane_contact.hpp"
#include "core/springs/spring_system.hpp"

namespace mss {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Columns of equal norm that are combinations of scaled ones, orthonormal; dependent ones are left out.
MatrixXd orthonormal(MatrixXd columns) {
  constexpr double independent = 1e-9;
  for (int twice = 0; twice < 2; ++twice) {  // the second time rounding is gone
    for (Index c = 0; c < columns.cols(); ++c) columns.col(c) /= std::max(columns.col(c).norm(), 1e-300);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(columns.transpose() * columns);
    Index first = 0;
    while (first < columns.cols() && gram.eigenvalues()[first] < independent) ++first;
    if (first == columns.cols()) throw InputError("nothing of the body can vibrate; hold less of it");
    const Index rank = columns.cols() - first;
    columns = columns * gram.eigenvectors().rightCols(rank) *
              gram.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
  }
  return columns;
}

/// Of scaled columns.
ReducedShapes made_of(RestBody& body, const MatrixXd& columns) {
  if (columns.cols() > most_coordinates)
    throw InputError(fmt::format(
        "vibrations, loads and planes make {} shapes, and at most {} can be computed with; give fewer "
        "material.modes, or material.model = \"springs\"",
        columns.cols(), most_coordinates));
  const MatrixXd basis = orthonormal(columns);
  const MatrixXd stiffness = basis.transpose() * body.product(0, 1, basis);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen((stiffness + stiffness.transpose()) / 2);
  const MatrixXd vibrations = basis * eigen.eigenvectors();
  ReducedShapes result;
  result.squares = eigen.eigenvalues().cwiseMax(0);
  result.damping = vibrations.cwiseProduct(body.product(1, 0, vibrations)).colwise().sum();
  const ParticleRows rows(body.system());
  result.shapes.resize(rows.count(), vibrations.cols());
  for (Index c = 0; c < vibrations.cols(); ++c)
    result.shapes.col(c) = rows.from(body.displacements(vibrations.col(c)), rows.count());
  return result;
}

Field<double> gravity_on(const SolidSystem<double>& system, const Vec3& gravity) {
  Field<double> f(system.size());
  for (const std::ptrdiff_t site : system.particles()) f.set(site, system.mass(site) * gravity);
  return f;
}

/// Unit pressure of a plane on the particles that come nearest to it as the body gives way to gravity.
Field<double> pressure_of(const Plane& plane, RestBody& body, const Environment& environment) {
  const SolidSystem<double>& system = body.system();
  const VectorXd load = body.scaled_forces(gravity_on(system, environment.gravity));
  const Field<double> sag = body.displacements(body.solve(load));
  double least = std::numeric_limits<double>::infinity();
  const auto gap = [&](std::ptrdiff_t site) { return plane.gap(system.rest_position(site) + sag.at(site)); };
  for (const std::ptrdiff_t site : system.particles()) least = std::min(least, gap(site));
  Field<double> f(system.size());
  for (const std::ptrdiff_t site : system.particles())
    if (gap(site) < least + system.cell_size() / 4) f.set(site, plane.normal);
  return f;
}

std::vector<Field<double>> forces_to_answer(RestBody& body, const Environment& environment) {
  const SolidSystem<double>& system = body.system();
  std::vector<Field<double>> forces;
  for (Load load : environment.loads) {
    load.history = {};
    Field<double> f(system.size());
    LoadedSites(system.levels(), {load})
        .add(0, 0, system.size(), std::array<double*, 3>{f.axis(0), f.axis(1), f.axis(2)});
    forces.push_back(std::move(f));
  }
  for (const Plane& plane : environment.planes)
    if (plane.contact == ContactLaw::penalty) forces.push_back(pressure_of(plane, body, environment));
  return forces;
}

/// How many vibrations of `count` shapes have all pairs among them: pairs are at most five eighths of all.
int paired_vibrations(int count) {
  int paired = 0;
  while (8 * (paired + 1) * (paired + 2) / 2 <= 5 * count) ++paired;
  return paired;
}

/// -f''(a, b), the force by which the body answers two small displacements together, by differences.
class SecondOrder {
 public:
  explicit SecondOrder(RestBody& body) : body_(body), f_(body.system().size()) {}

  VectorXd scaled(const VectorXd& a, const VectorXd& b) {
    const double size_a = size_of(a), size_b = size_of(b);
    VectorXd sum = VectorXd::Zero(a.size());
    for (const int sign_a : {1, -1})
      for (const int sign_b : {1, -1})
        sum += double(sign_a * sign_b) * force(sign_a * size_a * a + sign_b * size_b * b);
    return sum / (4 * size_a * size_b);
  }

 private:
  /// So that the largest displacement is a thousandth of a cell.
  double size_of(const VectorXd& y) const {
    return 1e-3 * body_.system().cell_size() / body_.displacements(y).array().abs().maxCoeff();
  }
  VectorXd force(const VectorXd& y) {
    State<double> state = body_.rest();
    state.x.array() += body_.displacements(y).array();
    body_.system().force(0, state.x, state.v, f_);
    return body_.scaled_forces(f_);
  }

  RestBody& body_;
  Field<double> f_;
};

}  // namespace

void ReducedShapes::remember(Record& record) {
  std::int64_t rows = shapes.rows(), columns = shapes.cols();
  record.keep(rows, columns);
  if (record.reads()) {
    shapes.resize(rows, columns);
    squares.resize(columns);
    damping.resize(columns);
  }
  for (const auto& [data, size] : {std::pair{shapes.data(), shapes.size()},
                                   {squares.data(), squares.size()},
                                   {damping.data(), damping.size()}})
    record.keep_values(std::span(data, std::size_t(size)));
}

ReducedShapes modal_shapes(RestBody& body, const Environment& environment, int modes) {
  const MatrixXd vibrations = body.slowest(modes).shapes;
  const std::vector<Field<double>> forces = forces_to_answer(body, environment);
  MatrixXd columns(vibrations.rows(), vibrations.cols() + Index(forces.size()));
  columns.leftCols(vibrations.cols()) = vibrations;
  for (std::size_t i = 0; i < forces.size(); ++i)
    columns.col(vibrations.cols() + Index(i)) = body.solve(body.scaled_forces(forces[i]));
  return made_of(body, columns);
}

ReducedShapes derivative_shapes(RestBody& body, int count) {
  int paired = paired_vibrations(count);
  const RestBody::Vibrations vibrations = body.slowest(std::max(count - paired * (paired + 1) / 2, paired));
  paired = std::min(paired, int(vibrations.squares.size()));
  const int pairs = paired * (paired + 1) / 2;
  SecondOrder second(body);
  MatrixXd answers(vibrations.shapes.rows(), pairs);
  for (int i = 0, pair = 0; i < paired; ++i)
    for (int j = 0; j <= i; ++j, ++pair)
      answers.col(pair) = second.scaled(vibrations.shapes.col(i), vibrations.shapes.col(j));
  MatrixXd columns(answers.rows(), vibrations.shapes.cols() + pairs);
  columns << vibrations.shapes, body.solve(answers);
  ReducedShapes result = made_of(body, columns);
  result.damping = result.damping[0] / result.squares[0] * result.squares;
  return result;
}

ReducedShapes centrifugal_shapes(RestBody& body, int count) {
  const SolidSystem<double>& system = body.system();
  Vec3 centre = Vec3::Zero();
  for (const std::ptrdiff_t site : system.particles())
    centre += system.mass(site) / system.total_mass() * system.rest_position(site);
  MatrixXd level(body.unknowns(), 6), columns(body.unknowns(), 0);
  for (int a = 0, load = 0; a < 3; ++a)
    for (int b = 0; b <= a; ++b, ++load) {
      Field<double> f(system.size());
      for (const std::ptrdiff_t site : system.particles()) {
        const Vec3 arm = system.mass(site) * (system.rest_position(site) - centre);
        f.set(site, arm[b] * Vec3::Unit(a) + (a == b ? Vec3(Vec3::Zero()) : Vec3(arm[a] * Vec3::Unit(b))));
      }
      level.col(load) = body.scaled_forces(f);
    }
  while (columns.cols() < count) {
    level = body.solve(level);  // of the forces y the answer, whose inertia is the next load
    for (Index c = 0; c < level.cols(); ++c) level.col(c).normalize();
    MatrixXd more(level.rows(), columns.cols() + level.cols());
    more << columns, level;
    columns = std::move(more);
  }
  return made_of(body, columns);
}

ReducedShapes shapes_of(RestBody& body, const MatrixXd& displacements) {
  const ParticleRows rows(body.system());
  MatrixXd columns(body.unknowns(), displacements.cols());
  Field<double> field(body.system().size());
  for (Index c = 0; c < displacements.cols(); ++c) {
    rows.write(displacements.col(c), field);
    columns.col(c) = body.scaled_displacements(field);
  }
  return made_of(body, columns);
}

}  // namespace mss
