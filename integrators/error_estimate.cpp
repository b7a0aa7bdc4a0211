#include "integrators/error_estimate.hpp"

#include <numeric>

#include "core/error.hpp"
#include "core/spring_system.hpp"
#include "integrators/linear_response.hpp"

namespace mss {

namespace {

constexpr double tolerance = 1e-10;  ///< of dual solutions: residual over right-hand side
constexpr TangentSum stiffness{.stiffness = 1, .kind = Tangent::elastic};

const Body& body_of_springs(const BodySystem<double>& system) {
  if (dynamic_cast<const SpringSystem<double>*>(&system) == nullptr)
    throw InputError("an estimate of the error needs cells of springs (material.model = \"springs\")");
  return system.body();
}

}  // namespace

ErrorEstimator::ErrorEstimator(BodySystem<double>& system, const State<double>& equilibrium, Work& work)
    : system_(system),
      recovery_(body_of_springs(system)),
      work_(work),
      linear_(false),
      rest_(system.undeformed_state()),
      at_(&equilibrium),
      displacement_(equilibrium.x) {
  displacement_.array() -= rest_.x.array();
  gradient_ = recovery_.gradient(recovery_.stress(equilibrium.x));
  prepare();
}

ErrorEstimator::ErrorEstimator(BodySystem<double>& system, const Field<double>& displacement, Work& work)
    : system_(system),
      recovery_(body_of_springs(system)),
      work_(work),
      linear_(true),
      rest_(system.undeformed_state()),
      at_(&rest_),
      displacement_(displacement) {
  gradient_ = recovery_.gradient(recovery_.stress_change(rest_.x, displacement));
  prepare();
}

void ErrorEstimator::prepare() {
  solver_ = find_linear_solver("automatic").make(tolerance);
  status_ = solver_->prepare(system_, at_->t, at_->x, at_->v, stiffness, work_);
}

/// 0 at prescribed coordinates.
Status ErrorEstimator::solve(const Field<double>& load, Field<double>& solution) {
  solution = Field<double>(system_.size());
  return status_ == Status::ok ? solver_->solve(load, solution, work_) : status_;
}

std::vector<double> ErrorEstimator::products(const Field<double>& dual) const {
  return recovery_.error_products(gradient_, recovery_.gradient(recovery_.stress_change(at_->x, dual)));
}

GoalEstimate ErrorEstimator::estimate(double value, double factor, Status status,
                                      const Field<double>& dual) const {
  GoalEstimate goal{.status = status, .value = value};
  if (status != Status::ok) return goal;
  goal.of_cells = products(dual);
  for (double& part : goal.of_cells) part *= factor;
  goal.error = std::accumulate(goal.of_cells.begin(), goal.of_cells.end(), 0.0);
  return goal;
}

GoalEstimate ErrorEstimator::displacement(const Field<double>& weight) {
  Field<double> dual;
  const Status status = solve(weight, dual);
  return estimate(inner(system_, weight, displacement_), 1, status, dual);
}

/// What acts on particles at the solution; about rest to first order.
Field<double> ErrorEstimator::total_force() {
  Field<double> force(system_.size());
  system_.force(at_->t, at_->x, at_->v, force);
  if (linear_) {
    Field<double> stiff(system_.size());
    tangents_of(system_).product(at_->t, at_->x, at_->v, stiffness, displacement_, stiff);
    force.array() -= stiff.array();
  }
  return force;
}

/// With z the direction at holds and K z = 0 elsewhere, J = a(u, z) - f(z) and J(u) - J(u_h) = -a(e, e_z).
GoalEstimate ErrorEstimator::reaction(const Field<double>& direction) {
  Field<double> held = direction, inside = direction, load(system_.size()), dual;
  system_.clear_prescribed(inside);
  held.array() -= inside.array();
  tangents_of(system_).product(at_->t, at_->x, at_->v, stiffness, held, load);
  load.array() *= -1;
  const Status status = solve(load, dual);
  dual.array() += held.array();

  return estimate(-inner(system_, held, total_force()), -1, status, dual);
}

double ErrorEstimator::energy() {
  if (!linear_) {
    const StoredEnergy stored = system_.stored_energy(at_->x);
    return stored.elastic + stored.volume;
  }
  Field<double> stiff(system_.size());
  tangents_of(system_).product(at_->t, at_->x, at_->v, stiffness, displacement_, stiff);
  return inner(system_, displacement_, stiff) / 2;
}

/// The total potential is as much too large as half the energy of the error, -1/2 a(e, e); the stored energy
/// is that and the loads' potential, whose error is that of a displacement.
GoalEstimate ErrorEstimator::stored_energy() {
  Field<double> load(system_.size()), dual;
  system_.force(at_->t, rest_.x, rest_.v, load);
  const Status status = solve(load, dual);
  GoalEstimate goal = estimate(energy(), 1, status, dual);
  if (goal.status != Status::ok) return goal;
  const std::vector<double> own = recovery_.error_products(gradient_, gradient_);
  for (std::size_t cell = 0; cell < own.size(); ++cell) goal.of_cells[cell] -= own[cell] / 2;
  goal.error = std::accumulate(goal.of_cells.begin(), goal.of_cells.end(), 0.0);
  return goal;
}

}  // namespace mss
