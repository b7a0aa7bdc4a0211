#include "integrators/analysis/error_estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/base/error.hpp"
#include "core/measures/particle_measures.hpp"
#include "core/refinement/marking.hpp"
#include "core/springs/spring_system.hpp"
#include "integrators/statics/linear_response.hpp"

namespace mss {

namespace {

constexpr double tolerance = 1e-10;  ///< of dual solutions: residual over right-hand side
constexpr TangentCoefficients stiffness{.stiffness = 1, .kind = Tangent::elastic};

const Body& body_of_springs(const BodySystem<double>& system) {
  if (!system.springs())
    throw InputError("an estimate of the error needs cells of springs (material.model = \"springs\")");
  return system.body();
}

constexpr double resolved_share = 0.25, agreeing_share = 0.8, spread_share = 0.05, thin_share = 0.1;
constexpr double small_strain = 0.05;
constexpr double most_missing = 0.5;  ///< of a stored energy
constexpr double negligible = 1e-9;   ///< of a value: parts that are rounding

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
std::string_view to_string(EstimateWarning doubt) {
  constexpr std::array<std::string_view, 8> names{"large", "far",     "concentrated", "re-entrant",
                                                  "thin",  "partial", "strained",     "contact"};
  return names[std::size_t(doubt)];
}

std::string to_string(const std::vector<EstimateWarning>& doubts) {
  std::string names;
  for (const EstimateWarning doubt : doubts)
    names += (names.empty() ? "" : ", ") + std::string(to_string(doubt));
  return names.empty() ? "none" : names;
}

std::string_view explanation(EstimateWarning doubt) {
  constexpr std::array<std::string_view, 8> sentences{
      "the estimate is more than a quarter of the value: smaller cells are needed",
      "parts of the estimate cancel: the quantity is far from what acts on the body, or across it, and the "
      "corrected value may be no better",
      "half of the estimate comes from less than a twentieth of the cells: a peak of stress is not resolved",
      "the body has edges that go inwards: the estimate sees three fifths to four fifths of the error there",
      "many cells have no neighbour along an axis: what bends them along it is not seen",
      "cells are filled in part: the estimate sees a quarter to two thirds of the error",
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
  find_doubts();
  prepare();
}

void GoalEstimator::prepare() {
  solver_ = find_linear_solver("automatic").make(tolerance);
  status_ = solver_->prepare(system_, at_->t, at_->x, at_->v, stiffness, work_);
}

void GoalEstimator::find_doubts() {
  const Body& body = system_.body();
  if (has_reentrant_edge(body)) doubts_.push_back(EstimateWarning::reentrant);
  if (recovery_.share_alone() > thin_share) doubts_.push_back(EstimateWarning::thin);
  if (recovery_.has_partial_cells()) doubts_.push_back(EstimateWarning::partial);
  if (!linear_ && largest_strain(body, at_->x) > small_strain) doubts_.push_back(EstimateWarning::strained);
  if (!system_.environment().planes.empty() || !system_.environment().obstacles.empty())
    doubts_.push_back(EstimateWarning::contact);
}

void GoalEstimator::add_doubts(GoalEstimate& goal) const {
  std::vector<double> parts = goal.of_cells;
  for (double& part : parts) part = std::abs(part);
  const double all = std::accumulate(parts.begin(), parts.end(), 0.0);
  if (all <= negligible * std::abs(goal.value)) {  // no estimate to doubt, but what may not be seen
    if (std::find(doubts_.begin(), doubts_.end(), EstimateWarning::thin) != doubts_.end())
      goal.doubts.push_back(EstimateWarning::thin);
    return;
  }
  if (std::abs(goal.error) > resolved_share * std::abs(goal.value))
    goal.doubts.push_back(EstimateWarning::large);
  if (std::abs(goal.error) < agreeing_share * all) goal.doubts.push_back(EstimateWarning::far);
  if (double(doerfler_marking(parts, 0.5).size()) < spread_share * double(parts.size()))
    goal.doubts.push_back(EstimateWarning::concentrated);
  goal.doubts.insert(goal.doubts.end(), doubts_.begin(), doubts_.end());
}

/// 0 at prescribed coordinates.
Status GoalEstimator::solve(const Field<double>& load, Field<double>& solution) {
  solution = Field<double>(system_.size());
  return status_ == Status::ok ? solver_->solve(load, solution, work_) : status_;
}

StrainField GoalEstimator::solution() const { return linear_ ? along(displacement_) : StrainField{at_->x}; }

/// By how much the error of a quantity is larger than that which discrete solutions have.
double GoalEstimator::shortfall(const Field<double>& dual) const {
  const DisplacementRecovery::Products own = recovery_.products(along(dual), along(dual));
  return own.stored > 0 ? 1 / (1 - std::min(own.error_of_all() / own.stored, most_missing)) : 1;
}

void GoalEstimator::add(double factor, const std::vector<double>& parts, GoalEstimate& goal) const {
  goal.of_cells.resize(parts.size());
  for (std::size_t cell = 0; cell < parts.size(); ++cell) {
    goal.of_cells[cell] += factor * parts[cell];
    goal.error += factor * parts[cell];
  }
}

GoalEstimate GoalEstimator::displacement(const Field<double>& weight) {
  Field<double> dual;
  GoalEstimate goal{.status = solve(weight, dual), .value = inner(system_, weight, displacement_)};
  if (goal.status != Status::ok) return goal;
  add(shortfall(dual), recovery_.products(solution(), along(dual)).error, goal);
  add_doubts(goal);
  return goal;
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
  GoalEstimate goal{.status = solve(load, dual), .value = -inner(system_, held, total_force())};
  if (goal.status != Status::ok) return goal;
  dual.array() += held.array();
  add(-1, recovery_.products(solution(), along(dual)).error, goal);
  add_doubts(goal);
  return goal;
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

/// With z the response to the loads and D = u_h - z that to the holds' motion, the stored energy is
/// a(z, z) / 2 + a(D, D) / 2: half a displacement under a load, and half a reaction.
GoalEstimate GoalEstimator::stored_energy() {
  Field<double> load(system_.size()), dual;
  system_.force(at_->t, rest_.x, rest_.v, load);
  GoalEstimate goal{.status = solve(load, dual), .value = energy()};
  if (goal.status != Status::ok) return goal;
  const std::vector<double> zz = recovery_.products(along(dual), along(dual)).error;
  add(shortfall(dual) / 2 - 0.5, zz, goal);
  add(1, recovery_.products(solution(), along(dual)).error, goal);
  add(-0.5, recovery_.products(solution(), solution()).error, goal);
  add_doubts(goal);
  return goal;
}

}  // namespace mss
