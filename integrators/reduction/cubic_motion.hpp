#pragma once

#include <vector>

#include "core/body/body.hpp"
#include "integrators/reduction/subspace_motion.hpp"

namespace mss {

/// The elastic force of a lattice in a subspace, f = -dE/dq. Springs store k / (8 L0^2) (|d|^2 - L0^2)^2, and
/// cells k_vol V0 / 2 (tr e)^2 with the Green strain e of their mean deformation: each is half the square of
/// an expression of second order in q, so E is a polynomial of fourth order, and exact as such.
class PolynomialForce {
 public:
  /// `shapes`: ParticleRows by columns, of the body's particles.
  PolynomialForce(const Body& body, const Eigen::MatrixXd& shapes);
  PolynomialForce(const PolynomialForce&) = delete;
  PolynomialForce& operator=(const PolynomialForce&) = delete;

  /// -f(q); `out` has padded() numbers.
  void gradient(const Eigen::VectorXd& q, Eigen::VectorXd& out) const {
    kernels_->cubic_force(polynomial_, q.data(), out.data());
  }
  Eigen::Index padded() const { return polynomial_.padded; }
  double energy(const Eigen::VectorXd& q) const;

 private:
  void set_coefficients(const Eigen::MatrixXd& squares, int coordinates);

  std::vector<double> linear_, quadratic_, cubic_;
  CubicForce polynomial_;
  const ReductionKernels* kernels_ = &fastest_copy<ReductionKernels>();
};

/// A body in a subspace with its full nonlinear force there, by leapfrog. Shapes faster than thirty times the
/// slowest get as much mass as makes them that fast, and steps are
/// divided where large motions make the body stiffer. Viscous forces are in proportion to the rate of the
/// elastic ones, by as much as damps the slowest shape right: constant damping would brake rotations.
class CubicMotion final : public SubspaceMotion {
 public:
  /// The body of the system's only lattice.
  CubicMotion(const System<double>& system, const Body& body, const State<double>& rest,
              const ReducedShapes& shapes, OuterForces outer);

  double longest_step() const override;
  bool step(double dt, long steps) override;
  double stored_energy(const Field<double>& x) override;
  void remember(Record& record) override;

 private:
  void restart() override { begun_ = false; }
  double stable_step(double square) const;
  long parts_of_step(double dt);
  /// Sets the acceleration at q; dt since the gradient before.
  void accelerate(double dt);
  void leap(double dt);

  PolynomialForce force_;
  double viscous_time_;  ///< forces over rates of elastic ones [s]
  bool begun_ = false;   ///< the acceleration is that at q
  Eigen::VectorXd acceleration_, gradient_, gradient_before_, gradient_beside_;
  Eigen::VectorXd fastest_direction_;  ///< about q, of length 1
};

/// `stretch` of SubspaceMotion for shapes whose omega^2 ascend.
Eigen::VectorXd mass_scaling(const Eigen::VectorXd& squares);

}  // namespace mss
