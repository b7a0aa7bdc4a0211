#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/base/record.hpp"
#include "core/environment/obstacle.hpp"
#include "core/scene/scene.hpp"
#include "core/springs/solid_system.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// How far the steps of a run were from solved.
struct Imbalance {
  enum class Over { weight, inertia, reactions };
  double share = 0;          ///< forces that are out of balance over those that `over` says
  Over over = Over::weight;  ///< weight and loads, or masses times accelerations, or what holds and planes do
};

/// Measures how far steps of methods that iterate towards backward Euler (xpbd, vbd, and backward_euler as
/// far as `iterations` limits it) are from having solved it:
///   r = M (v' - v) / dt - f(x', v'),   v' = (x' - x) / dt.
/// At rest that is what a body hangs too low for, however small its motion in a step. Of particles that no
/// plane touches, and coordinates that nothing prescribes: there it is the reaction.
///
/// Forces that alternate from particle to particle are left by every pass and move little, so those count
/// that a polynomial of second degree in the places at rest follows, with the norm
///   |P r|^2 = b^T G^-1 b,   b = sum_i phi(X_i) r_i,   G = sum_i m_i phi(X_i) phi(X_i)^T,
/// which of a weight m_i g is M g^2.
class StepBalance {
 public:
  /// Share from which on the result of few iterations is another material's.
  static constexpr double tolerated = 0.05;

  /// All must outlive it.
  StepBalance(const Scene& scene, SolidSystem<double>& system, double dt);

  /// Whether the scene's method solves backward Euler's equations step by step, in double precision.
  static bool applies_to(const Scene& scene);

  /// Adds the step of dt that led from one state to the other.
  void add(const State<double>& before, const State<double>& after);

  /// Of all steps added; nothing where there is no force but by rounding.
  std::optional<Imbalance> imbalance() const;
  void remember(Record& record) { record.keep(residual_, weight_, inertia_, reactions_, steps_); }

 private:
  static constexpr int functions = 10;
  using Values = Eigen::Matrix<double, functions, 1>;
  using Moments = Eigen::Matrix<double, functions, 3>;

  Values values(std::ptrdiff_t site) const;
  double squared_norm(const Moments& moments) const;
  bool is_touched(const Vec3& x, const Vec3& next, const Vec3& v, double t) const;

  const Scene& scene_;
  SolidSystem<double>& system_;
  double dt_;
  double margin_;  ///< from planes [m]
  std::vector<ObstacleSurface> obstacles_;
  Vec3 middle_;   ///< of the body at rest [m]
  double reach_;  ///< [m]
  Eigen::Matrix<double, functions, functions> inverse_gram_;
  Field<double> free_axes_;  ///< 1 where nothing prescribes a coordinate
  Field<double> velocity_, force_;
  double residual_ = 0, weight_ = 0, inertia_ = 0, reactions_ = 0;  ///< squared norms, summed over steps
  double steps_ = 0;
};

}  // namespace mss
