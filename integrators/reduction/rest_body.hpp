#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/springs/body_system.hpp"
#include "integrators/analysis/scaled_tangent.hpp"
#include "integrators/linear/cholmod.hpp"

namespace mss {

/// Small motions of a body about rest in its boundary conditions, in coordinates scaled by the roots of its
/// masses, y = M^1/2 u: A = M^-1/2 K M^-1/2, factored once. What reduces a body is made of solutions with it.
///
/// Boundary conditions leave it either no rigid motion or all six: then everything is orthogonal to these.
class RestBody {
 public:
  /// The body, of springs, must outlive it. Throws InputError, one sentence, where it is not stable at rest,
  /// where its boundary conditions leave some rigid motions, and where these move it.
  RestBody(const Body& body, const Environment& environment);

  SolidSystem<double>& system() { return *system_; }
  const State<double>& rest() const { return rest_; }
  bool is_free() const { return rigid_.cols() > 0; }
  Eigen::Index unknowns() const { return roots().size(); }
  const Eigen::VectorXd& roots() const { return tangent_->roots(); }

  /// M^-1/2 f of forces, and M^1/2 u of displacements; without what would move a free body as a whole.
  Eigen::VectorXd scaled_forces(const Field<double>& f) const;
  Eigen::VectorXd scaled_displacements(const Field<double>& u) const;
  /// u = M^-1/2 y
  Field<double> displacements(const Eigen::VectorXd& y) const;

  /// A^-1 y by columns, y without rigid motions.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& y);
  /// (b C + c K), scaled, times columns.
  Eigen::MatrixXd product(double damping, double stiffness, const Eigen::MatrixXd& y);

  /// The slowest vibrations as orthonormal columns, ascending, with omega^2 [1/s^2]; fewer where there are no
  /// more. By Lanczos with A^-1.
  struct Vibrations {
    Eigen::VectorXd squares;
    Eigen::MatrixXd shapes;
  };
  Vibrations slowest(int count);

 private:
  Vibrations search(const Eigen::MatrixXd& others, Eigen::Index wanted);
  Eigen::VectorXd without_rigid(Eigen::VectorXd y) const;
  void find_rigid_motions();
  void factor();

  std::unique_ptr<BodySystem<double>> system_;
  State<double> rest_;
  std::unique_ptr<ScaledTangent> tangent_;
  Eigen::MatrixXd rigid_;  ///< orthonormal columns; none where it is held
  Cholesky cholesky_;
};

}  // namespace mss
