#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>

#include "core/system/reduced_motion.hpp"
#include "integrators/reduction/reduced_shapes.hpp"

namespace mss {

/// Forces on a reduced body from outside: gravity, loads, planes that push.
struct OuterForces {
  bool change_in_time = false, depend_on_state = false;
  bool turns = false;    ///< more than gravity: it may turn and deform a free body
  bool nothing = false;  ///< there are none
  /// Of a method of second order, that resolves them [s].
  double longest_step = std::numeric_limits<double>::infinity();
  /// f [N] at a time and a state; overwritten. Of `state` only what depend_on_state says is read.
  std::function<void(double t, const State<double>& state, Field<double>& f)> at;

  bool change() const { return change_in_time || depend_on_state; }
};

/// A reduced body whose system asks what it has stored.
class ElasticMotion : public ReducedMotion {
 public:
  /// Elastic energy of the coordinates nearest to positions x [J].
  virtual double stored_energy(const Field<double>& x) = 0;
  /// Of states that were taken, the largest share of displacements from rest, or of velocities, in the norm
  /// of masses, that is no sum of shapes; 0 where that is not asked.
  virtual double lost() const { return 0; }
  /// Angular frequency of the fastest coordinate at rest [rad/s].
  virtual double fastest() const = 0;
};

/// A body held at rest, whose particles are displaced by a sum of shapes: x = X + U q. The derived class says
/// how q moves.
class SubspaceMotion : public ElasticMotion {
 public:
  /// The system must outlive it; rest: where particles are undeformed. `stretch`, one number per shape,
  /// divides them: their masses are multiplied by its square.
  SubspaceMotion(const System<double>& system, const State<double>& rest, const ReducedShapes& shapes,
                 OuterForces outer, const Eigen::VectorXd& stretch);

  int coordinates() const override { return int(q_.size()); }
  double fastest() const override { return std::sqrt(squares_.maxCoeff()); }
  void take(const State<double>& state) override;
  void give(State<double>& state) const override;
  void draw(Field<double>& x) const override;
  void remember(Record& record) override;
  double lost() const override { return lost_; }

 protected:
  /// Positions of particles, in rows.
  virtual void place(const Eigen::VectorXd& q, Eigen::VectorXd& rows) const;
  /// Their velocities.
  virtual void move(const Eigen::VectorXd& q, const Eigen::VectorXd& rates, Eigen::VectorXd& rows) const;
  /// Coordinates nearest to positions x in rows, and rates nearest to velocities v there.
  virtual Eigen::VectorXd nearest(const Eigen::VectorXd& x) const;
  virtual Eigen::VectorXd nearest_rates(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const;
  /// U^T f at a time and coordinates.
  virtual void pull(const Eigen::VectorXd& q, const Eigen::VectorXd& forces, Eigen::VectorXd& pulls) const;

  /// Whether pulls of the same forces change with q.
  virtual bool pulls_change() const { return false; }

  /// Pulls of outer forces; kept where they do not change.
  const Eigen::VectorXd& outer_pull(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& rates);
  /// Coordinates at positions x: those that it has, or where x is another state the nearest.
  Eigen::VectorXd coordinates_at(const Field<double>& x) const;
  /// What follows from q, rates and t must be found anew.
  virtual void restart() {}

  const ParticleRows& rows() const { return rows_; }
  const ShapePanels& panels() const { return panels_; }
  const Eigen::VectorXd& rest_rows() const { return rest_; }
  const Eigen::VectorXd& masses() const { return masses_; }  ///< by row; 0 in padding
  const OuterForces& outer() const { return outer_; }

  Eigen::VectorXd squares_, damping_;  ///< of shapes as they are used
  Eigen::VectorXd q_, rates_;
  double t_ = 0;

 private:
  double norm(const Eigen::VectorXd& rows) const;

  ParticleRows rows_;
  Eigen::VectorXd stretch_;
  ShapePanels panels_;
  ShapePanelsIn<float> drawn_;
  Eigen::VectorXf zero_of_drawn_;
  mutable Eigen::VectorXf moved_;
  Eigen::VectorXd rest_, masses_, zero_;
  OuterForces outer_;
  Eigen::VectorXd pull_, forces_;
  bool knows_pull_ = false;
  double lost_ = 0;
  State<double> scratch_;
  Field<double> force_;
  mutable Eigen::VectorXd rows_out_;
};

/// Vibrations that do not know of each other, each by its exact solution under a force that is constant in a
/// step: q'' + d q' + omega^2 q = p. Steps have no limit but that of forces that change.
class ModalMotion : public SubspaceMotion {
 public:
  ModalMotion(const System<double>& system, const State<double>& rest, const ReducedShapes& shapes,
              OuterForces outer);

  double longest_step() const override;
  bool step(double dt, long steps) override;
  double stored_energy(const Field<double>& x) override;

 private:
  void propagate_over(double dt);

  double dt_ = 0;
  /// (q, q') after a step: q_q q + q_v q' + q_p p, v_q q + v_v q' + v_p p.
  Eigen::ArrayXd q_q_, q_v_, q_p_, v_q_, v_v_, v_p_;
  Eigen::ArrayXd before_;
};

}  // namespace mss
