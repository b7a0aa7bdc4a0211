#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/refinement/displacement_recovery.hpp"
#include "core/springs/body_system.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/linear_solver.hpp"

namespace mss {

/// Why an estimate may be far from the error.
enum class EstimateWarning {
  large,         ///< it is more than a quarter of the value: the cells do not resolve the solution
  far,           ///< parts of cells cancel: the quantity is far from what acts on the body, or across it
  concentrated,  ///< half of it comes from less than a twentieth of the cells: a peak of stress
  reentrant,     ///< the body has edges that go inwards: stress has no bound there, and the estimate sees
                 ///< three fifths to four fifths of the error
  thin,          ///< many cells have no neighbour along an axis, so that the second derivative is unknown
  partial,       ///< cells are filled in part, and what that changes at a surface is not seen
  strained,      ///< strains above 5 percent: the estimate is linear about the equilibrium
  contact        ///< what touches a plane changes with the cells
};
std::string_view to_string(EstimateWarning doubt);
/// Their names in a row, "none" without any, as tables have them.
std::string to_string(const std::vector<EstimateWarning>& doubts);
/// What it means, as the rest of a sentence.
std::string_view explanation(EstimateWarning doubt);

/// What the cells' size is estimated to change in a quantity J.
struct GoalEstimate {
  Status status = Status::ok;      ///< of the dual solution; the rest is valid only if it is ok
  double value = 0;                ///< J(u_h), as computed
  double error = 0;                ///< J(u) - J(u_h): what to add
  std::vector<double> of_cells{};  ///< its parts by cell id; their magnitudes say which cells to refine
  std::vector<EstimateWarning> doubts{};  ///< none: it is to be trusted
  double corrected() const { return value + error; }
};

/// Estimates how far quantities of a static solution u_h are from those of infinitely small cells.
///
/// With K the tangent at u_h, the dual solution z of a quantity J solves K z = dJ/du, and
///   J(u) - J(u_h) ~ sum over cells of eta(u_h, z),
/// eta(a, b) = a_h(a, b) - a(a, b) + a(w_a, w_b) being what a lattice's energy has more than a continuum's of
/// the recovered displacements (displacement_recovery.hpp, where it is derived for z = u). Of the
/// displacement under a body's only load z is u_h itself. Of a reaction z is the unit displacement of its
/// hold, and the sum counts negative: a body in smaller cells is softer.
///
/// eta of the true solutions is larger: z_h falls short of z. If it does so everywhere by the same factor, so
/// that z = b z_h and, with z = u, the displacement J(u) = b J(u_h), then J(u) - J(u_h) = b^2 eta(z_h, z_h) -
/// (b - 1)^2 a_h(z_h, z_h), and
///   b = 1 / (1 - eta(z_h, z_h) / a_h(z_h, z_h)).
/// By that b the sum is multiplied, at most by 2. Where a hold's motion deforms the body nothing falls short.
///
/// To first order about rest, or about an equilibrium of large displacements: then strains are Green's, which
/// stay as they are when the body rotates, z is of the tangent there, and the work of present stresses at
/// second gradients is neglected, which is small where strains are.
class GoalEstimator {
 public:
  /// At an equilibrium, whose state must outlive it, as the system must. Throws InputError as
  /// DisplacementRecovery does, and for a system without tangents or of another model.
  GoalEstimator(BodySystem<double>& system, const State<double>& equilibrium, Work& work);
  /// About rest, in which the displacement is the response to the loads.
  GoalEstimator(BodySystem<double>& system, const Field<double>& displacement, Work& work);

  const DisplacementRecovery& recovery() const { return recovery_; }

  /// Sum of weight . u over the particles.
  GoalEstimate displacement(const Field<double>& weight);
  /// Sum of direction . reaction over the held coordinates; others of the direction are ignored.
  GoalEstimate reaction(const Field<double>& direction);
  /// Stored energy [J]: half of the loads' work about rest.
  GoalEstimate stored_energy();

 private:
  void prepare();
  void find_doubts();
  Status solve(const Field<double>& load, Field<double>& solution);
  StrainField solution() const;
  StrainField along(const Field<double>& displacement) const { return {at_->x, &displacement}; }
  double shortfall(const Field<double>& dual) const;
  void add(double factor, const std::vector<double>& parts, GoalEstimate& goal) const;
  void add_doubts(GoalEstimate& goal) const;
  Field<double> total_force();
  double energy();

  BodySystem<double>& system_;
  DisplacementRecovery recovery_;
  Work& work_;
  bool linear_;
  State<double> rest_;
  const State<double>* at_;              ///< what the tangent is of
  Field<double> displacement_;           ///< u_h
  std::vector<EstimateWarning> doubts_;  ///< about any quantity
  std::unique_ptr<LinearSolver> solver_;
  Status status_ = Status::ok;
};

}  // namespace mss
