#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "integrators/linear/linear_solver.hpp"

namespace mss {

/// Inverses of the 3 x 3 diagonal blocks of a tangent, for all particles at once.
class BlockJacobi {
 public:
  void prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
               const TangentSum& sum);
  /// z = blocks^-1 r, 0 where there is no unknown; returns r.z and r.r.
  struct Products {
    double rz, rr;
  };
  Products apply(const Field<double>& r, Field<double>& z) const;

  /// 1 at unknowns, 0 elsewhere.
  const Field<double>& mask() const { return mask_; }

 private:
  std::vector<Eigen::Matrix3d> blocks_;
  std::vector<AlignedArray<double>> inverse_;  ///< xx xy xz yy yz zz over sites
  Field<double> mask_;
};

/// Preconditioned conjugate gradients for y with A y = r (Hestenes and Stiefel, 1952). What multiplies by A
/// is the derived class's choice; everything else is the same code, so that choices can be compared.
class ConjugateGradients : public LinearSolver {
 public:
  /// Stops when |r - A y| <= tolerance |r|.
  explicit ConjugateGradients(double tolerance) : tolerance_(tolerance) {}

  Status prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                 const TangentSum& sum, Work& work) override;
  /// Status linear_stalled if the tolerance is not met after as many iterations as there are unknowns (and at
  /// least a hundred), not_positive_definite if a direction of negative curvature turns up.
  Status solve(const Field<double>& rhs, Field<double>& solution, Work& work) override;

 protected:
  virtual void prepare_product(System<double>& system, double t, const Field<double>& x,
                               const Field<double>& v, const TangentSum& sum, Work& work) = 0;
  /// out = A p; prescribed coordinates of `out` may hold anything.
  virtual void product(const Field<double>& p, Field<double>& out) = 0;

 private:
  double tolerance_;
  System<double>* system_ = nullptr;
  long most_iterations_ = 0;
  BlockJacobi preconditioner_;
  Field<double> residual_, z_, direction_, image_;
};

}  // namespace mss
