#pragma once

#include <array>

#include "core/coloured_particles.hpp"
#include "core/descent.hpp"

namespace mss {

/// Minimises the objective of a step of backward Euler, particle by particle and colour by colour: what a
/// step of vertex block descent iterates.
///
/// Particles of one colour are no neighbours, so results are the same bits for any number of threads.
template <class Real>
class VertexDescent {
 public:
  /// Both must outlive it: `springs` are the body and its holds, the threads of `system`, which may be a
  /// wrapper, do the work.
  VertexDescent(const SpringSystem<Real>& springs, System<Real>& system, double dt);

  /// What its passes read and write points into it.
  VertexDescent(const VertexDescent&) = delete;
  VertexDescent& operator=(const VertexDescent&) = delete;

  ColouredParticles<Real>& particles() { return particles_; }

  /// Begins a step: the target is where particles would be without springs, and so is the first guess but for
  /// accelerations.
  void begin_step();
  /// One pass over all particles.
  void iterate();
  /// The same; then ends the step and begins the next, with the same accelerations.
  void iterate_into_next_step();

 private:
  void fill_dictionary();
  void fill_lane(const std::uint32_t* lane, Real* coefficients) const;
  std::uint8_t planes_of(const Real* coefficients) const;
  Descent<Real> part_of(int colour);

  System<Real>& system_;
  ColouredParticles<Real> particles_;
  const DescentKernel<Real>& kernel_;
  bool damped_;
  double dt_;
  ColouredBlocks blocks_;
  AlignedArray<Real> dictionary_;
  std::vector<std::uint8_t> planes_;  ///< per entry, see Descent
  Field<Real> target_;
  std::array<Descent<Real>, ColouredLattice::colours> parts_;  ///< what a pass over a colour is told
};

}  // namespace mss
