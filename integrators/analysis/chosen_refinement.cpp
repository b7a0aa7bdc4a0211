#include "integrators/analysis/chosen_refinement.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <memory>

#include "core/base/error.hpp"
#include "core/refinement/marking.hpp"
#include "core/refinement/refined_system.hpp"
#include "integrators/linear/linear_solver.hpp"

namespace mss {

namespace {

constexpr double no_displacement = 1e-12;  ///< over another, or the size of a cell
constexpr TangentCoefficients elastic_stiffness{.stiffness = 1, .kind = Tangent::elastic};

/// Whether no rigid motion is left to a solid: of the six, about its first particle in lengths of its cells,
/// none leaves all held coordinates as they are.
bool is_kept_in_place(const SolidSystem<double>& system) {
  using Motions = Eigen::Matrix<double, 6, 6>;
  Field<double> ones(system.size());
  for (const std::ptrdiff_t site : system.particles()) ones.set(site, Vec3::Ones());
  system.clear_prescribed(ones);
  const Vec3 first = system.rest_position(system.particles().front());
  Motions held = Motions::Zero();
  for (const std::ptrdiff_t site : system.particles()) {
    const Vec3 arm = (system.rest_position(site) - first) / system.cell_size();
    for (int axis = 0; axis < 3; ++axis) {
      if (ones.axis(axis)[site] != 0) continue;
      Eigen::Matrix<double, 6, 1> moves;  // of the coordinate in each motion
      moves << Vec3::Unit(axis), arm.cross(Vec3::Unit(axis));
      held += moves * moves.transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Motions> solver(held, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[0] > 1e-9 * solver.eigenvalues()[5];
}

/// The equilibrium of a body in the cells chosen so far, to first order.
class Equilibrium {
 public:
  Equilibrium(const RefinedBody& body, const Environment& environment, const RefinementGoal& goal);
  const Field<double>& displacement() const { return u_; }
  /// The dual solution of the mean displacement of a box along its own direction.
  Field<double> dual(const Box& box);

 private:
  Field<double> solve(const Field<double>& load);
  Field<double> moved_by_holds(double time) const;

  const RefinedBody& body_;
  std::unique_ptr<SolidSystem<double>> system_;
  State<double> rest_;
  Work work_;
  std::unique_ptr<LinearSolver> solver_;
  Field<double> u_;
  double largest_ = 0;  ///< of its coordinates
};

Equilibrium::Equilibrium(const RefinedBody& body, const Environment& environment, const RefinementGoal& goal)
    : body_(body),
      system_(make_solid_system<double>(body, environment, {.threads = goal.threads})),
      rest_(system_->undeformed_state()),
      solver_(find_linear_solver("automatic").make(1e-8)) {
  if (!is_kept_in_place(*system_))
    throw InputError(
        "cells are chosen by an equilibrium at rest, and holds do not keep the body in place; give "
        "[[refine]]");
  const Status status = solver_->prepare(*system_, 0, rest_.x, rest_.v, elastic_stiffness, work_);
  if (status != Status::ok)
    throw InputError(
        fmt::format("the equilibrium that cells are chosen by was not found: {}", to_string(status)));
  const Field<double> held = moved_by_holds(goal.time);
  Field<double> load(system_->size()), stiff(system_->size());
  system_->force(0, rest_.x, rest_.v, load);
  tangents_of(*system_).product(0, rest_.x, rest_.v, elastic_stiffness, held, stiff);
  load.array() -= stiff.array();
  u_ = solve(load);
  u_.array() += held.array();
  largest_ = u_.array().abs().maxCoeff();
  if (!(largest_ > no_displacement * system_->cell_size()))
    throw InputError("no load, weight or hold deforms the body, so that no cells can be chosen");
}

Field<double> Equilibrium::solve(const Field<double>& load) {
  Field<double> solution(system_->size());
  const Status status = solver_->solve(load, solution, work_);
  if (status != Status::ok)
    throw InputError(
        fmt::format("the equilibrium that cells are chosen by was not found: {}", to_string(status)));
  return solution;
}

/// At prescribed coordinates, from rest.
Field<double> Equilibrium::moved_by_holds(double time) const {
  State<double> state = rest_;
  system_->constrain(time, state.x, state.v);
  Field<double> moved(system_->size());
  for (const std::ptrdiff_t site : system_->particles()) moved.set(site, state.x.at(site) - rest_.x.at(site));
  Field<double> free = moved;
  system_->clear_prescribed(free);
  moved.array() -= free.array();
  return moved;
}

Field<double> Equilibrium::dual(const Box& box) {
  Field<double> weight(system_->size());
  std::vector<std::ptrdiff_t> sites = select(body_.levels(), box);
  std::erase_if(sites, [&](std::ptrdiff_t site) { return system_->mass(site) == 0; });  // hanging ones
  Vec3 mean = Vec3::Zero();
  for (const std::ptrdiff_t site : sites) mean += u_.at(site) / double(sites.size());
  if (!(mean.norm() > no_displacement * largest_))
    throw InputError("what cells are chosen for does not move; give another goal");
  for (const std::ptrdiff_t site : sites) weight.set(site, mean.normalized() / double(sites.size()));
  return solve(weight);
}

}  // namespace

RefinementMap choose_refinement(const BodyConfig& config, const Environment& environment,
                                const RefinementGoal& goal) {
  Environment acting = environment;
  acting.planes.clear();
  acting.obstacles.clear();
  RefinementMap map;
  for (int level = 0; level < goal.levels; ++level) {
    const RefinedBody body(config, map);
    Equilibrium equilibrium(body, acting, goal);
    const Field<double>& u = equilibrium.displacement();
    if (goal.box) {
      const Field<double> dual = equilibrium.dual(*goal.box);
      map = split_by_estimate(body, u, &dual);
    } else {
      map = split_by_estimate(body, u);
    }
  }
  return map;
}

}  // namespace mss
