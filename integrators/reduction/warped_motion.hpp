#pragma once

#include "core/body/body.hpp"
#include "integrators/reduction/subspace_motion.hpp"

namespace mss {

/// Modal warping (Choi and Ko, IEEE TVCG 11 (2005) 91): vibrations as in ModalMotion, each particle's
/// displacement turned by the mean of the rotations that its vibrations turn it through,
///   x = X + R~(theta) U q,   theta = W q,   R~(theta) = integral of R(s theta) for s from 0 to 1,
/// with W half the curl of U. Forces are turned back: p = U^T R(theta)^T f, theta from the middle of a step.
class WarpedMotion final : public ModalMotion {
 public:
  /// The body of the system's only lattice.
  WarpedMotion(const System<double>& system, const Body& body, const State<double>& rest,
               const ReducedShapes& shapes, OuterForces outer);

  void draw(Field<double>& x) const override;

 private:
  void place(const Eigen::VectorXd& q, Eigen::VectorXd& rows) const override;
  void move(const Eigen::VectorXd& q, const Eigen::VectorXd& rates, Eigen::VectorXd& rows) const override;
  Eigen::VectorXd nearest(const Eigen::VectorXd& x) const override;
  Eigen::VectorXd nearest_rates(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const override;
  void pull(const Eigen::VectorXd& q, const Eigen::VectorXd& forces, Eigen::VectorXd& pulls) const override;
  bool pulls_change() const override { return true; }

  /// dv/dq' at q, by columns.
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& q) const;

  Eigen::Index particles_;
  ShapePanels rotations_;
  Eigen::VectorXd zero_;
  mutable Eigen::VectorXd angles_, shifts_, angle_rates_, shift_rates_, turned_, placed_;
};

/// Half the curl of displacements (ParticleRows by columns), by differences of second order to the next
/// particles along edges of cells, on one side where there is none on the other.
Eigen::MatrixXd half_curls(const Body& body, const Eigen::MatrixXd& displacements);

}  // namespace mss
