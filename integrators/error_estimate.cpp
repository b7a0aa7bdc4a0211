#include "integrators/error_estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/particle_measures.hpp"
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

constexpr double resolved_share = 0.25, agreeing_share = 0.8, spread_share = 0.05, thin_share = 0.1;
constexpr double least_agreement = 0.6, most_agreement = 1.6;  ///< of the other estimate, over the estimate
constexpr double small_strain = 0.05;
constexpr double negligible = 1e-9;  ///< of a value: parts that are rounding

/// Whether some edge of the lattice lies in three of the four cells around it.
bool has_reentrant_edge(const Body& body) {
  const VoxelGrid& cells = body.config().voxels;
  const auto around = [&](int axis, const std::array<int, 3>& at) {
    int count = 0;
    for (int corner = 0; corner < 4; ++corner) {
      std::array<int, 3> cell = at;
      cell[std::size_t(axis + 1) % 3] -= corner & 1;
      cell[std::size_t(axis + 2) % 3] -= corner >> 1;
      count += cells.at(cell[0], cell[1], cell[2]) ? 1 : 0;
    }
    return count;
  };
  for (int k = 0; k <= cells.nz(); ++k)
    for (int j = 0; j <= cells.ny(); ++j)
      for (int i = 0; i <= cells.nx(); ++i)
        for (int axis = 0; axis < 3; ++axis)
          if (around(axis, {i, j, k}) == 3) return true;
  return false;
}

/// Largest change of a spring's length over its length at rest.
double largest_strain(const Body& body, const Field<double>& x) {
  double largest = 0;
  for (const std::ptrdiff_t site : body.sites()) largest = std::max(largest, stretch_at({body}, x, site));
  return largest;
}

}  // namespace

// In the enumeration's order.
std::string_view to_string(Doubt doubt) {
  constexpr std::array<std::string_view, 9> names{"large",   "far",     "concentrated", "re-entrant", "thin",
                                                  "partial", "springs", "strained",     "contact"};
  return names[std::size_t(doubt)];
}

std::string to_string(const std::vector<Doubt>& doubts) {
  std::string names;
  for (const Doubt doubt : doubts) names += (names.empty() ? "" : ", ") + std::string(to_string(doubt));
  return names.empty() ? "none" : names;
}

std::string_view explanation(Doubt doubt) {
  constexpr std::array<std::string_view, 9> sentences{
      "the estimate is more than a quarter of the value: smaller cells are needed",
      "parts of the estimate cancel: the quantity is far from what acts on the body, or across it, and the "
      "corrected value may be no better",
      "half of the estimate comes from less than a twentieth of the cells: a peak of stress is not resolved",
      "the body has edges that go inwards: the estimate sees half to three quarters of the error there",
      "many cells have no neighbour along an axis: the estimate is too small",
      "cells are filled in part: the estimate sees less than half of the error",
      "what springs store in uneven cells says something else: the estimate may be off by half or more",
      "strains exceed 5 percent: the estimate is linear",
      "what touches a plane changes with the cells, which the estimate does not see"};
  return sentences[std::size_t(doubt)];
}

GoalEstimator::GoalEstimator(BodySystem<double>& system, const State<double>& equilibrium, Work& work)
    : system_(system),
      recovery_(body_of_springs(system)),
      work_(work),
      linear_(false),
      rest_(system.undeformed_state()),
      at_(&equilibrium),
      displacement_(equilibrium.x) {
  displacement_.array() -= rest_.x.array();
  gradient_ = recovery_.gradient(recovery_.stress(equilibrium.x));
  strains_ = recovery_.spring_strains(equilibrium.x);
  find_doubts();
  prepare();
}

GoalEstimator::GoalEstimator(BodySystem<double>& system, const Field<double>& displacement, Work& work)
    : system_(system),
      recovery_(body_of_springs(system)),
      work_(work),
      linear_(true),
      rest_(system.undeformed_state()),
      at_(&rest_),
      displacement_(displacement) {
  gradient_ = recovery_.gradient(recovery_.stress_change(rest_.x, displacement));
  strains_ = recovery_.spring_strain_change(rest_.x, displacement);
  find_doubts();
  prepare();
}

void GoalEstimator::prepare() {
  solver_ = find_linear_solver("automatic").make(tolerance);
  status_ = solver_->prepare(system_, at_->t, at_->x, at_->v, stiffness, work_);
}

void GoalEstimator::find_doubts() {
  const Body& body = system_.body();
  if (has_reentrant_edge(body)) doubts_.push_back(Doubt::reentrant);
  if (recovery_.share_alone() > thin_share) doubts_.push_back(Doubt::thin);
  if (recovery_.has_partial_cells()) doubts_.push_back(Doubt::partial);
  if (!linear_ && largest_strain(body, at_->x) > small_strain) doubts_.push_back(Doubt::strained);
  if (!system_.environment().planes.empty()) doubts_.push_back(Doubt::contact);
}

void GoalEstimator::add_doubts(GoalEstimate& goal) const {
  std::vector<double> parts = goal.of_cells;
  for (double& part : parts) part = std::abs(part);
  const double all = std::accumulate(parts.begin(), parts.end(), 0.0);
  const bool thin = std::find(doubts_.begin(), doubts_.end(), Doubt::thin) != doubts_.end();
  if (all <= negligible * std::abs(goal.value) && !thin) return;
  if (std::abs(goal.error) > resolved_share * std::abs(goal.value)) goal.doubts.push_back(Doubt::large);
  const bool far = std::abs(goal.error) < agreeing_share * all;
  if (far) goal.doubts.push_back(Doubt::far);
  if (double(doerfler_marking(parts, 0.5).size()) < spread_share * double(parts.size()))
    goal.doubts.push_back(Doubt::concentrated);
  const double agreement = goal.of_springs / goal.error;
  if (!far && !(agreement > least_agreement && agreement < most_agreement))
    goal.doubts.push_back(Doubt::springs);
  goal.doubts.insert(goal.doubts.end(), doubts_.begin(), doubts_.end());
}

/// 0 at prescribed coordinates.
Status GoalEstimator::solve(const Field<double>& load, Field<double>& solution) {
  solution = Field<double>(system_.size());
  return status_ == Status::ok ? solver_->solve(load, solution, work_) : status_;
}

GoalEstimate GoalEstimator::estimate(double value, double factor, Status status,
                                     const Field<double>& dual) const {
  GoalEstimate goal{.status = status, .value = value};
  if (status != Status::ok) return goal;
  add(factor, recovery_.gradient(recovery_.stress_change(at_->x, dual)),
      recovery_.spring_strain_change(at_->x, dual), goal);
  add_doubts(goal);
  return goal;
}

void GoalEstimator::add(double factor, const CellStressGradient& gradient,
                        const std::vector<SpringStrain>& strains, GoalEstimate& goal) const {
  const std::vector<double> parts = recovery_.error_products(gradient_, gradient);
  const std::vector<double> uneven = recovery_.uneven_products(strains_, strains);
  goal.of_cells.resize(parts.size());
  for (std::size_t cell = 0; cell < parts.size(); ++cell) {
    goal.of_cells[cell] += factor * parts[cell];
    goal.error += factor * parts[cell];
    goal.of_springs += factor * (uneven[cell] - parts[cell]);
  }
}

GoalEstimate GoalEstimator::displacement(const Field<double>& weight) {
  Field<double> dual;
  const Status status = solve(weight, dual);
  return estimate(inner(system_, weight, displacement_), 1, status, dual);
}

/// What acts on particles at the solution; about rest to first order.
Field<double> GoalEstimator::total_force() {
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
GoalEstimate GoalEstimator::reaction(const Field<double>& direction) {
  Field<double> held = direction, inside = direction, load(system_.size()), dual;
  system_.clear_prescribed(inside);
  held.array() -= inside.array();
  tangents_of(system_).product(at_->t, at_->x, at_->v, stiffness, held, load);
  load.array() *= -1;
  const Status status = solve(load, dual);
  dual.array() += held.array();

  return estimate(-inner(system_, held, total_force()), -1, status, dual);
}

double GoalEstimator::energy() {
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
GoalEstimate GoalEstimator::stored_energy() {
  Field<double> load(system_.size()), dual;
  system_.force(at_->t, rest_.x, rest_.v, load);
  const Status status = solve(load, dual);
  GoalEstimate goal = estimate(energy(), 1, status, dual);
  goal.doubts.clear();
  if (goal.status != Status::ok) return goal;
  add(-0.5, gradient_, strains_, goal);
  add_doubts(goal);
  return goal;
}

}  // namespace mss
