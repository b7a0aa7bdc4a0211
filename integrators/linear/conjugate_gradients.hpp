#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "integrators/linear/linear_solver.hpp"

namespace mss {

/// Inverses of the 3 x 3 diagonal blocks of a tangent, for all particles at once.
class BlockJacobi {
 public:
  /// `mask`: 1 at unknowns, 0 elsewhere.
  void prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
               const TangentCoefficients& sum, const Field<double>& mask);
  /// Sites [first, last).
  struct Range {
    std::ptrdiff_t first, last;
  };
  /// r.z and r.r of a range.
  struct Products {
    double rz = 0, rr = 0;
  };
  /// z = blocks^-1 r in a range, 0 where there is no unknown.
  Products apply(const Field<double>& r, Field<double>& z, Range range) const;

 private:
  std::vector<Eigen::Matrix3d> blocks_;
  std::vector<AlignedArray<double>> inverse_;  ///< xx xy xz yy yz zz over sites
};

/// Preconditioned conjugate gradients for y with A y = r (Hestenes and Stiefel, 1952). The derived class
/// multiplies by A and may replace the block-Jacobi preconditioner; everything else is the same code, so that
/// ways to do these can be compared.
class ConjugateGradients : public LinearSolver {
 public:
  /// Stops when |r - A y| <= tolerance |r|.
  explicit ConjugateGradients(double tolerance) : tolerance_(tolerance) {}

  Status prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                 const TangentCoefficients& sum, Work& work) override;
  /// Status linear_stalled if the tolerance is not met after as many iterations as there are unknowns (and at
  /// least a hundred), not_positive_definite if a direction, or the preconditioner, has negative curvature.
  Status solve(const Field<double>& rhs, Field<double>& solution, Work& work) override;

 protected:
  using Range = BlockJacobi::Range;
  using Products = BlockJacobi::Products;

  virtual void prepare_product(System<double>& system, double t, const Field<double>& x,
                               const Field<double>& v, const TangentCoefficients& sum, Work& work) = 0;
  /// out = A p; prescribed coordinates of `out` may have any value.
  virtual void product(const Field<double>& p, Field<double>& out) = 0;

  virtual Status prepare_preconditioner(System<double>& system, double t, const Field<double>& x,
                                        const Field<double>& v, const TangentCoefficients& sum, Work& work);
  /// Calls update(range) for every range of sites, which may change r, then sets z = P^-1 r, 0 where there is
  /// no unknown; P is symmetric and positive definite. Returns r.z and r.r. Where r.r <= enough, z and r.z
  /// may have any value.
  virtual Products precondition(const std::function<void(Range)>& update, const Field<double>& r,
                                Field<double>& z, double enough);

  /// precondition() for one that needs the whole residual: apply(|r|) sets z, unless r.r <= enough.
  Products precondition_whole(const std::function<void(Range)>& update, const Field<double>& r,
                              Field<double>& z, double enough, const std::function<void(double)>& apply);

  /// Calls part(range) for ranges of sites that do not depend on the number of threads, and adds up what it
  /// returns, always in the same order.
  Products sum_over_ranges(const std::function<Products(Range)>& part);

  /// 1 at unknowns, 0 elsewhere.
  const Field<double>& mask() const { return mask_; }

 private:
  double tolerance_;
  System<double>* system_ = nullptr;
  std::vector<Products> sums_;  ///< of ranges
  long most_iterations_ = 0;
  Field<double> mask_;
  BlockJacobi block_jacobi_;
  Field<double> residual_, z_, direction_, image_;
};

}  // namespace mss
