#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "integrators/position_based/coloured_particles.hpp"
#include "integrators/position_based/displacement_contact.hpp"

namespace mss {

/// The springs and cells of a body as compliant constraints, projected colour by colour: what a step of XPBD
/// iterates.
///
/// Cells of one colour have no particle in common, so results are the same bits for any number of threads.
template <class Real>
class XpbdSolver {
 public:
  /// Both must outlive it: `springs` are the body and its holds, the threads of `system`, which may be a
  /// wrapper, do the work. `multipliers`: whether they are kept from one pass to the next.
  XpbdSolver(const SpringSystem<Real>& springs, System<Real>& system, double dt, bool multipliers);

  /// What its passes read and write points into it.
  XpbdSolver(const XpbdSolver&) = delete;
  XpbdSolver& operator=(const XpbdSolver&) = delete;

  ColouredParticles<Real>& particles() { return particles_; }

  /// Begins a step: the particles' displacements without springs, multipliers 0.
  void begin_step(double t);
  /// Where the system has bounds: after the last pass of a step, and after velocities have followed from it.
  void end_passes();
  void rebound(State<Real>& state) const;
  /// See Integrator::remember().
  void remember(Record& record) {
    if (contact_) record.keep(*contact_);
  }
  /// One pass over all constraints.
  void iterate();
  /// The same; then ends the step and begins the next, with the same accelerations: plane by plane, while its
  /// particles are in the cache.
  void iterate_into_next_step();

 private:
  void fill_dictionary();
  void fill_lane(const std::uint32_t* lane, Real* coefficients) const;
  void forget_multipliers();
  /// Calls finished(parity, plane) for a plane of the parts with that parity of z when none of its particles
  /// will be moved again in this pass.
  template <class Finished>
  void pass(Finished&& finished);
  Projection<Real> part_of(int colour);

  System<Real>& system_;
  ColouredParticles<Real> particles_;
  const XpbdKernel<Real>& kernel_;
  bool damped_;
  bool keeps_multipliers_;
  double dt_;
  ColouredBlocks blocks_;
  AlignedArray<Real> dictionary_;
  std::vector<std::uint8_t> is_flat_;  ///< per entry, see Projection
  std::array<AlignedArray<Real>, ColouredLattice::colours> multipliers_;
  std::unique_ptr<DisplacementContact<Real>> contact_;            ///< nullptr: nothing bounds particles
  std::array<Projection<Real>, ColouredLattice::colours> parts_;  ///< what a pass over a colour is told
};

}  // namespace mss
