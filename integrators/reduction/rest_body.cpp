#include "integrators/reduction/rest_body.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.hpp"
#include "core/springs/spring_system.hpp"
#include "integrators/analysis/spectra.hpp"
#include "integrators/linear/unknowns.hpp"

namespace mss {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The boundary conditions alone, which must not move the body.
Environment holds_of(const Environment& environment) {
  Environment alone;
  alone.holds = environment.holds;
  for (const Hold& hold : alone.holds)
    if (hold.moves() || !hold.displacement.isZero(0))
      throw InputError(
          "a hold moves what it holds, and shapes of a reduced body are about rest; leave its motion out, or "
          "give material.model = \"springs\"");
  return alone;
}

/// The six rigid motions of all particles about their centre, in rows of unknowns scaled by roots of masses;
/// `held` adds what they do to held coordinates.
MatrixXd rigid_motions(const SolidSystem<double>& system, const std::vector<FreeDof>& dofs, bool scale) {
  Vec3 centre = Vec3::Zero();
  for (const std::ptrdiff_t site : system.particles())
    centre += system.mass(site) / system.total_mass() * system.rest_position(site);
  MatrixXd motions(Index(dofs.size()), 6);
  for (Index i = 0; i < motions.rows(); ++i) {
    const auto [site, axis] = dofs[std::size_t(i)];
    const Vec3 arm = system.rest_position(site) - centre;
    const double root = scale ? std::sqrt(system.mass(site)) : 1;
    for (int k = 0; k < 3; ++k) {
      motions(i, k) = axis == k ? root : 0;
      motions(i, 3 + k) = root * Vec3::Unit(k).cross(arm)[axis];
    }
  }
  return motions;
}

/// Adds vibrations to others and sorts all, ascending.
void merge(const RestBody::Vibrations& next, RestBody::Vibrations& all) {
  VectorXd squares(all.squares.size() + next.squares.size());
  squares << all.squares, next.squares;
  MatrixXd shapes(next.shapes.rows(), squares.size());
  shapes << all.shapes, next.shapes;
  std::vector<Index> order(std::size_t(squares.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Index i, Index j) { return squares[i] < squares[j]; });
  all = {.squares = squares(order), .shapes = shapes(Eigen::all, order)};
}

std::vector<FreeDof> held_coordinates(const BodySystem<double>& system) {
  std::vector<FreeDof> held;
  for (const std::ptrdiff_t site : system.particles())
    for (int axis = 0; axis < 3; ++axis)
      if (system.held().holds(site, axis)) held.push_back({site, axis});
  return held;
}

}  // namespace

RestBody::RestBody(const Body& body, const Environment& environment)
    : system_(std::make_unique<SpringSystem<double>>(body, holds_of(environment), Execution{.threads = 1})),
      rest_(system_->rest_state()),
      tangent_(std::make_unique<ScaledTangent>(*system_, rest_)) {
  find_rigid_motions();
  factor();
}

void RestBody::find_rigid_motions() {
  const std::vector<FreeDof> held = held_coordinates(*system_);
  if (held.empty()) {
    const MatrixXd motions = rigid_motions(*system_, tangents_of(*system_).unknowns(), true);
    rigid_ = Eigen::HouseholderQR<MatrixXd>(motions).householderQ() * MatrixXd::Identity(motions.rows(), 6);
    return;
  }
  MatrixXd stopped = rigid_motions(*system_, held, false);
  stopped.rightCols(3) /= stopped.rightCols(3).cwiseAbs().maxCoeff() + 1e-300;
  if (Eigen::ColPivHouseholderQR<MatrixXd>(stopped).setThreshold(1e-9).rank() < 6)
    throw InputError(
        "the holds leave the body free to move as a whole in some ways, and a reduced body is held wholly or "
        "not at all; give [[hold]] more particles or axes, leave it out, or give material.model = "
        "\"springs\"");
}

/// Without holds A alone is singular. The shift changes answers by its ratio to omega^2 of what they are made
/// of: a thousandth for a slender free bar of a hundred cells, less elsewhere.
void RestBody::factor() {
  SparseMatrix matrix = tangent_->matrix(0, 1);
  if (is_free()) matrix.diagonal().array() += 1e-9 * std::pow(system_->spectral_bound().omega, 2);
  if (cholesky_.factor(matrix) != Status::ok)
    throw InputError(
        "the body is not stable at rest, so it has no vibrations to be reduced to; give other springs, or "
        "material.model = \"springs\"");
}

VectorXd RestBody::without_rigid(VectorXd y) const {
  if (is_free()) y -= rigid_ * (rigid_.transpose() * y);
  return y;
}

VectorXd RestBody::scaled_forces(const Field<double>& f) const {
  VectorXd y;
  gather(tangents_of(*system_).unknowns(), f, y);
  return without_rigid(y.cwiseQuotient(roots()));
}

VectorXd RestBody::scaled_displacements(const Field<double>& u) const {
  VectorXd y;
  gather(tangents_of(*system_).unknowns(), u, y);
  return without_rigid(y.cwiseProduct(roots()));
}

Field<double> RestBody::displacements(const VectorXd& y) const {
  return tangent_->to_field(y.cwiseQuotient(roots()));
}

MatrixXd RestBody::solve(const MatrixXd& y) {
  MatrixXd solutions(y.rows(), y.cols());
  VectorXd column;
  for (Index c = 0; c < y.cols(); ++c) {
    cholesky_.solve(VectorXd(y.col(c)), column);
    solutions.col(c) = without_rigid(column);
  }
  return solutions;
}

MatrixXd RestBody::product(double damping, double stiffness, const MatrixXd& y) {
  MatrixXd image;
  Work work;
  tangent_->multiply(damping, stiffness, y, image, work);
  return image;
}

/// The slowest of what is orthogonal to others: Lanczos may find one of several equal frequencies only.
RestBody::Vibrations RestBody::search(const MatrixXd& others, Index wanted) {
  const Index rows = unknowns(), available = rows - rigid_.cols() - others.cols();
  VectorXd rhs, solution;
  const auto project = [&](VectorXd y) {
    y = without_rigid(std::move(y));
    if (others.cols() > 0) y -= others * (others.transpose() * y);
    return y;
  };
  const auto inverse = [&](const double* in, double* out) {
    rhs = project(Eigen::Map<const VectorXd>(in, rows));
    cholesky_.solve(rhs, solution);
    Eigen::Map<VectorXd>(out, rows) = project(solution);
  };
  const auto pairs = lanczos({rows, inverse}, {.wanted = wanted,
                                               .space = std::min(2 * wanted + 12, available),
                                               .most_restarts = 1000,
                                               .tolerance = 1e-8});
  if (pairs.status != Status::ok)
    throw InputError("the body's vibrations were not found; give fewer material.modes");
  return {.squares = pairs.values.cwiseInverse(), .shapes = pairs.vectors};
}

RestBody::Vibrations RestBody::slowest(int count) {
  const Index rows = unknowns(), available = rows - rigid_.cols(), wanted = std::min<Index>(count, available);
  constexpr Index few = 200;
  if (rows <= few) {  // all of them
    const Eigen::SelfAdjointEigenSolver<MatrixXd> all(MatrixXd(tangent_->matrix(0, 1)));
    return {.squares = all.eigenvalues().segment(rigid_.cols(), wanted),
            .shapes = all.eigenvectors().middleCols(rigid_.cols(), wanted)};
  }
  Vibrations found{.squares = VectorXd(0), .shapes = MatrixXd(rows, 0)};
  while (true) {
    const Index missing = wanted - found.squares.size();
    if (found.squares.size() >= available) break;
    const Vibrations next = search(found.shapes, std::max<Index>(1, missing));
    const bool is_check = missing <= 0;
    if (is_check && next.squares[0] >= found.squares[wanted - 1] * (1 - 1e-6)) break;
    merge(next, found);
  }
  return {.squares = found.squares.head(wanted), .shapes = found.shapes.leftCols(wanted)};
}

}  // namespace mss
