#pragma once

#include <array>
#include <memory>

#include "integrators/position_based/coloured_particles.hpp"
#include "integrators/position_based/displacement_contact.hpp"
#include "integrators/position_based/vbd_kernel.hpp"

namespace mss {

/// Contact in a pass: a particle near a plane moves to the minimum of its quadratic model under Coulomb's law
/// (block_in_cone.hpp).
template <class Real>
class VertexContact final : public DescentContact<Real> {
 public:
  /// Both must outlive it. Of steps of dt [s].
  VertexContact(DisplacementContact<Real>& near, ColouredParticles<Real>& particles, double dt)
      : near_(near), particles_(particles), dt_(dt) {}
  bool touches(std::ptrdiff_t index, int count) const override;
  void move(std::ptrdiff_t index, const Real (&hessian)[6], const Real (&force)[3],
            const Real (&u)[3]) const override;

 private:
  void keep(const Vec3& force, const Vec3& free, typename DisplacementContact<Real>::Near& near) const;

  DisplacementContact<Real>& near_;
  ColouredParticles<Real>& particles_;
  double dt_;
};

/// Minimises the objective of a step of backward Euler, particle by particle and colour by colour: what a
/// step of vertex block descent iterates.
///
/// Particles of one colour are no neighbours, so results are the same bits for any number of threads.
template <class Real>
class VbdSolver {
 public:
  /// Both must outlive it: `springs` are the body and its holds, the threads of `system`, which may be a
  /// wrapper, do the work.
  /// `chebyshev_radius`: spectral radius of a pass, from 0 to below 1; 0: passes are not accelerated.
  VbdSolver(const SpringSystem<Real>& springs, System<Real>& system, double dt, double chebyshev_radius = 0);

  /// What its passes read and write points into it.
  VbdSolver(const VbdSolver&) = delete;
  VbdSolver& operator=(const VbdSolver&) = delete;

  ColouredParticles<Real>& particles() { return particles_; }

  /// Begins a step: the target is where particles would be without springs. The first guess is x + dt v +
  /// dt^2 a, with the acceleration of the step before: along gravity cut to between 0 and g; in the
  /// first step gravity itself (Chen et al., section 3.7). Of bodies that touch planes also what is across
  /// gravity, cut to g: passes are slow to set a body sliding.
  void begin_step(double t);
  /// Where the system has bounds: after the last pass of a step, and after velocities have followed from it.
  void end_passes();
  void rebound(State<Real>& state) const;
  /// Forgets the step before.
  void reset() { has_step_before_ = false; }
  /// See Integrator::remember().
  void remember(Record& record) {
    record.keep(has_step_before_);
    record.keep_field(drift_, particles_.lattice().size());
    if (near_) record.keep(*near_);
  }
  /// One pass over all particles, and Chebyshev's semi-iteration if it is accelerated: u_k = w_k (u -
  /// u_{k-2})
  /// + u_{k-2}, u what the pass makes of u_{k-1}, w_1 = 1, w_2 = 2 / (2 - rho^2), w_k = 4 / (4 - rho^2
  /// w_{k-1}). Chen, Liu, Yang and Yuksel, section 3.8.
  void iterate();
  /// The same; then ends the step and begins the next, with the same accelerations.
  void iterate_into_next_step();

 private:
  void fill_dictionary();
  void fill_lane(const std::uint32_t* lane, Real* coefficients) const;
  std::uint8_t planes_of(const Real* coefficients) const;
  void pass();
  void guess();
  void shorten_guess(const Vec3& normal);
  double objective();
  Descent<Real> part_of(int colour);

  System<Real>& system_;
  const SpringSystem<Real>& springs_;
  ColouredParticles<Real> particles_;
  const VbdKernel<Real>& kernel_;
  bool damped_;
  double dt_;
  double squared_radius_;  ///< of a pass
  double weight_ = 1;      ///< w_k
  int passes_ = 0;         ///< of this step
  ColouredBlocks blocks_;
  AlignedArray<Real> dictionary_;
  std::vector<std::uint8_t> planes_;  ///< per entry, see Descent
  Field<Real> target_;
  Field<Real> drift_;  ///< dt v of the step before
  bool has_step_before_ = false;
  Vec3 gravity_;
  std::unique_ptr<DisplacementContact<Real>> near_;  ///< nullptr: nothing bounds particles
  std::unique_ptr<VertexContact<Real>> contact_;
  Field<Real> last_, one_before_;  ///< u_{k-1}, u_{k-2}; empty without acceleration
  std::array<Descent<Real>, ColouredLattice::colours> parts_;  ///< what a pass over a colour is told
};

}  // namespace mss
