#pragma once

#include <array>

#include "integrators/reduction/subspace_motion.hpp"

namespace mss {

/// A free body whose shapes move in a frame that floats with it: x = c + R (X + U q), X from the centre of
/// mass, U orthogonal to rigid motions (mean axes: the frame has the body's momentum and angular momentum as
/// if it were rigid in its present shape). Coordinates q and their momenta p = U^T M R^T (v - c'), angular
/// momentum L about the centre:
///   (J(q) - B B^T) w = R^T L - B p,   q' = p - B^T w,   R' = R [w],
///   p' = -omega^2 q - d q' + (w.dJ/dq w) / 2 - w.A q' + U^T R^T f,
/// J the inertia of the present shape, B_c = A_c q; the frame's turn is a quaternion. Steps are the classical
/// ones of Runge and Kutta. Without outer forces L stays what it is to the last bit.
class FloatingMotion final : public ElasticMotion {
 public:
  /// As SubspaceMotion.
  FloatingMotion(const SolidSystem<double>& system, const State<double>& rest, const ReducedShapes& shapes,
                 OuterForces outer);

  int coordinates() const override { return int(at_.q.size()); }
  double fastest() const override { return std::sqrt(squares_.maxCoeff()); }
  double longest_step() const override;
  void take(const State<double>& state) override;
  bool step(double dt, long steps) override;
  void give(State<double>& state) const override;
  void draw(Field<double>& x) const override;
  double stored_energy(const Field<double>& x) override;
  void remember(Record& record) override;

 private:
  /// What q makes of the body's inertia.
  struct Inertia {
    /// By pair xx, yy, zz, half of dS/dq; by xy, xz, yz all of it.
    std::array<Eigen::VectorXd, 6> change;
    std::array<Eigen::VectorXd, 3> b;  ///< A_c q
    Eigen::Matrix3d moment;            ///< J - B B^T
  };
  void find_inertia();
  /// What is stepped; and its rates.
  struct Moving {
    Eigen::VectorXd q, p;
    Eigen::Vector4d turn = Eigen::Vector4d::UnitW();  ///< quaternion (x, y, z, w) of the frame
    Vec3 centre = Vec3::Zero(), velocity = Vec3::Zero(), angular_momentum = Vec3::Zero();

    void add(double dt, const Moving& rates);
  };
  /// Finds frame_, spin_ and rates_ of q, p, turn and angular momentum.
  void find_velocities();
  Moving rates_at(double t);
  void add_outer(double t, Moving& rates);
  void turn_by_forces(Moving& rates);
  Vec3 sum_of(const Eigen::VectorXd& forces) const;
  Eigen::Matrix3d frame_of(const Eigen::VectorXd& arms) const;
  Eigen::VectorXd centred(const Field<double>& field, Vec3& mean) const;
  /// out = r rows + offset, by particle; not in place.
  void turn(const Eigen::Matrix3d& r, const Eigen::VectorXd& rows, const Vec3& offset,
            Eigen::VectorXd& out) const;
  Eigen::VectorXd turned(const Eigen::Matrix3d& r, const Eigen::VectorXd& rows) const;

  ParticleRows rows_;
  Eigen::Index particles_;
  ShapePanels panels_;
  ShapePanelsIn<float> drawn_;
  Eigen::VectorXf drawn_arms_;
  mutable Eigen::VectorXf moved_;
  Eigen::VectorXd squares_, damping_, masses_, arms_, zero_;
  double mass_;
  /// Stacked: sums of G by pair of axes, then A_c, each r x r; and A_c alone.
  ShapePanels of_shape_, of_rates_;
  Eigen::VectorXd zero_of_shape_, zero_of_rates_;
  std::array<Eigen::VectorXd, 6> first_;  ///< what shapes do to S to first order
  std::array<double, 6> inertia_;         ///< S of the undeformed body
  OuterForces outer_;
  State<double> scratch_;
  Field<double> force_;
  Eigen::VectorXd forces_;
  Vec3 total_force_ = Vec3::Zero();
  bool knows_force_ = false;

  double t_ = 0;
  Moving at_;

  Eigen::Matrix3d frame_ = Eigen::Matrix3d::Identity();
  Inertia now_;
  Vec3 spin_ = Vec3::Zero();  ///< w, in the frame [rad/s]
  Eigen::VectorXd rates_, shape_out_, rates_out_;
  mutable Eigen::VectorXd rows_out_, shifts_;
};

}  // namespace mss
