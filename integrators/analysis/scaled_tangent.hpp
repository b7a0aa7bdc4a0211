#pragma once

#include <Eigen/Core>

#include "core/springs/solid_system.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Damping and stiffness of a body's small motions about a state, with the masses of its unknowns scaled to
/// 1: A = M^-1/2 (b C + c K) M^-1/2 with the elastic tangents b C + c K.
class ScaledTangent {
 public:
  /// System and state must outlive it. Throws InputError if the system has no tangents.
  ScaledTangent(SolidSystem<double>& system, const State<double>& state);

  Eigen::Index unknowns() const { return roots_.size(); }
  /// Of the masses [kg^1/2].
  const Eigen::VectorXd& roots() const { return roots_; }
  Field<double> to_field(const Eigen::VectorXd& unknowns) const;

  SparseMatrix matrix(double damping, double stiffness) const;

  /// y = A x, columns by columns; y is resized. Through the sweep where cells are of springs, and elsewhere,
  /// where a product without a matrix takes as long as assembling it, by matrices that are kept.
  void multiply(double damping, double stiffness, const Eigen::MatrixXd& x, Eigen::MatrixXd& y, Work& work);

 private:
  void sweep(const TangentCoefficients& sum, const Eigen::MatrixXd& x, Eigen::MatrixXd& y);

  SolidSystem<double>& system_;
  const State<double>& state_;
  Eigen::VectorXd roots_;
  SparseMatrix damping_, stiffness_;  ///< empty until they are needed
  Field<double> in_, out_;
  Eigen::VectorXd column_;
};

}  // namespace mss
