#include "integrators/linear/constant_matrix.hpp"

#include <algorithm>
#include <vector>

#include "integrators/linear/cholmod.hpp"
#include "integrators/linear/unknowns.hpp"

namespace mss {

namespace {

std::size_t index(SpringSlot::Class kind) { return static_cast<std::size_t>(kind); }

double stiffness_of(const SpringConstants& springs, SpringSlot::Class kind) {
  return std::array{springs.edge, springs.face, springs.body}[index(kind)];
}

/// By class, a slot that every topology with such springs has.
constexpr std::array<std::size_t, 3> slot_of_class{0, 3, 9};

/// The matrix for the particles that are free along some axes, and these axes.
struct FreeParticles {
  std::vector<int> axes;
  std::vector<std::ptrdiff_t> sites;
  std::vector<int> row;  ///< per site; -1: held
  Eigen::MatrixXd rhs, solution;
  Cholesky cholesky;
};

class CholeskySolver final : public ConstantSolver {
 public:
  CholeskySolver(const Body& body, System<double>& system);
  Status prepare(const ConstantMatrix& matrix) override;
  void solve(System<double>& system, const Field<double>& rhs, Field<double>& solution) override;

 private:
  SparseMatrix assemble(const ConstantMatrix& matrix, const FreeParticles& particles) const;

  const Body& body_;
  std::vector<std::unique_ptr<FreeParticles>> groups_;
};

CholeskySolver::CholeskySolver(const Body& body, System<double>& system) : body_(body) {
  const Field<double> unknown = mask_of_unknowns(system);
  for (int axis = 0; axis < 3; ++axis) {
    const double* mask = unknown.axis(axis);
    const auto same = std::find_if(groups_.begin(), groups_.end(), [&](const auto& group) {
      return std::equal(mask, mask + system.size(), unknown.axis(group->axes.front()));
    });
    if (same != groups_.end()) {
      (*same)->axes.push_back(axis);
      continue;
    }
    auto group = std::make_unique<FreeParticles>();
    group->axes = {axis};
    group->row.assign(std::size_t(system.size()), -1);
    for (const std::ptrdiff_t site : body.sites())
      if (mask[site] != 0) {
        group->row[std::size_t(site)] = int(group->sites.size());
        group->sites.push_back(site);
      }
    groups_.push_back(std::move(group));
  }
}

SparseMatrix CholeskySolver::assemble(const ConstantMatrix& matrix, const FreeParticles& particles) const {
  std::vector<Eigen::Triplet<double>> entries;
  const auto join = [&](std::ptrdiff_t a, std::ptrdiff_t b, double weight) {
    const int row_a = particles.row[std::size_t(a)], row_b = particles.row[std::size_t(b)];
    if (row_a >= 0) entries.emplace_back(row_a, row_a, weight);
    if (row_b >= 0) entries.emplace_back(row_b, row_b, weight);
    if (row_a < 0 || row_b < 0) return;
    entries.emplace_back(row_a, row_b, -weight);
    entries.emplace_back(row_b, row_a, -weight);
  };
  body_.for_each_spring(
      [&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double stiffness, double) {
        const std::size_t kind = index(slot.kind);
        join(a, b, matrix.spring[kind] * stiffness / body_.kinds().interior_stiffness(slot_of_class[kind]));
      });
  body_.for_each_cell([&](std::ptrdiff_t site) {
    const double weight = matrix.cell_edge * body_.weights_at(site).volume;
    for (int c = 0; c < 8; ++c)
      for (const int step : {1, 2, 4})
        if ((c & step) == 0)
          join(site + body_.lattice().corner(c), site + body_.lattice().corner(c | step), weight);
  });
  for (std::size_t i = 0; i < particles.sites.size(); ++i)
    entries.emplace_back(int(i), int(i), matrix.mass * body_.mass(particles.sites[i]));
  const auto rows = Eigen::Index(particles.sites.size());
  SparseMatrix assembled(rows, rows);
  assembled.setFromTriplets(entries.begin(), entries.end());
  return assembled;
}

Status CholeskySolver::prepare(const ConstantMatrix& matrix) {
  for (const auto& group : groups_)
    if (const Status status = group->cholesky.factor(assemble(matrix, *group)); status != Status::ok)
      return status;
  return Status::ok;
}

void CholeskySolver::solve(System<double>&, const Field<double>& rhs, Field<double>& solution) {
  solution.array() = 0;
  for (const auto& group : groups_) {
    group->rhs.resize(Eigen::Index(group->sites.size()), Eigen::Index(group->axes.size()));
    for (std::size_t c = 0; c < group->axes.size(); ++c)
      for (std::size_t i = 0; i < group->sites.size(); ++i)
        group->rhs(Eigen::Index(i), Eigen::Index(c)) = rhs.axis(group->axes[c])[group->sites[i]];
    group->cholesky.solve(group->rhs, group->solution);
    for (std::size_t c = 0; c < group->axes.size(); ++c)
      for (std::size_t i = 0; i < group->sites.size(); ++i)
        solution.axis(group->axes[c])[group->sites[i]] = group->solution(Eigen::Index(i), Eigen::Index(c));
  }
}

}  // namespace

ConstantMatrix bounding_matrix(const Body& body, double a, double b, double c) {
  const BodyConfig& config = body.config();
  ConstantMatrix matrix{.mass = a};
  for (const auto kind : {SpringSlot::Class::edge, SpringSlot::Class::face, SpringSlot::Class::body}) {
    const double interior = body.kinds().interior_stiffness(slot_of_class[index(kind)]);
    for (const Part& part : body.parts()) {
      // Of an interior spring: between two whole particles.
      const double mass = part.density * body.cell_volume(), k = stiffness_of(part.springs, kind);
      if (k == 0 || interior == 0) continue;
      const double shear_modulus = cubic_stiffness(part.springs, config.cell_size).c44;
      const double weight =
          c * k + b * part.damping.coefficient(k, mass, mass, body.rest_length(kind), shear_modulus);
      matrix.spring[index(kind)] = std::max(matrix.spring[index(kind)], weight * (interior / k));
    }
  }
  matrix.cell_edge = c * 0.75 * std::max(body.kinds().interior_volume(), 0.0) * config.cell_size;
  return matrix;
}

std::unique_ptr<ConstantSolver> cholesky_solver(const Body& body, System<double>& system) {
  return std::make_unique<CholeskySolver>(body, system);
}

}  // namespace mss
