#pragma once

#include <array>
#include <memory>

#include "core/springs/spring_system.hpp"
#include "integrators/position_based/displacement_contact.hpp"
#include "integrators/position_based/shape_kernel.hpp"

namespace mss {

/// Lattice shape matching: every particle is the centre of a region, the particles at most `width` sites away
/// along every axis; a region's goal is its rest shape, moved and turned as it fits best; a particle's goal
/// is the mean of those of the regions it is in. Rivers and James, FastLSM: fast lattice shape matching for
/// robust real-time deformation, ACM TOG 26 (2007) 82; sums over regions axis by axis, as there. Regions are
/// boxes: parts of a body that come closer than that across a gap share them. Width 0 makes the whole body
/// one region: Mueller, Heidelberger, Teschner and Gross, Meshless deformations based on shape matching, ACM
/// TOG 24 (2005) 471.
///
/// There are no springs in it, and no modulus: how stiff a body is follows from the width, the step, and
/// `alpha`, the share of the way to its goal that a particle goes in a step.
class ShapeMatching {
 public:
  /// Both must outlive it: `springs` are the body and its holds, the threads of `system`, which may be a
  /// wrapper, do the work.
  ShapeMatching(const SpringSystem<double>& springs, System<double>& system, double dt, int width,
                double alpha);

  ShapeMatching& particles() { return *this; }

  /// Takes over positions and velocities.
  void load_state(const State<double>& state);
  /// And accelerations that are constant during steps; those of held coordinates do not count.
  void load_acceleration(const Field<double>& acceleration);
  /// Writes the positions and velocities of all particles.
  void store_state(State<double>& state) const;

  /// Begins a step: u = dt v + dt^2 a.
  void begin_step(double t);
  /// The displacement of a particle in this step [m].
  void set_displacement(std::ptrdiff_t site, int axis, double u);
  /// u += alpha (goal - x).
  void iterate();
  /// The same; then ends the step and begins the next, with the same accelerations.
  void iterate_into_next_step();
  /// Ends a step: x += u, v = u / dt.
  void finish(double dt);
  /// Where the system has bounds: applies planes to where particles are going, by contact's multipliers on
  /// mass alone, and restitution to their velocities.
  void end_passes();
  void rebound(State<double>& state) const;
  /// Forgets how regions were turned, where the next search for rotations would begin.
  void reset();
  /// See Integrator::remember().
  void remember(Record& record);

 private:
  using Array = AlignedArray<double>;
  using Affine = std::array<Array, affine_size>;

  void place(const HeldSites& held, double alpha);
  void find_regions();
  template <class Part>
  void for_each_plane(Part&& part);
  void sum_over_regions(Affine& fields, Affine& scratch);
  void sum_over_regions(Array& field);
  void match_whole_body();
  ShapeSites sites(std::ptrdiff_t first, std::ptrdiff_t last);

  const Body& body_;
  System<double>& system_;
  const ShapeKernel& kernel_;
  double dt_;
  int width_;        ///< of margins and regions
  bool whole_body_;  ///< one region
  std::ptrdiff_t row_, plane_, size_;
  std::vector<std::ptrdiff_t> index_;  ///< of every particle
  std::array<Array, 3> rest_, rest_centre_, x_, v_, u_, acceleration_, freedom_;
  std::unique_ptr<DisplacementContact<double>> contact_;  ///< nullptr: nothing bounds particles
  Array share_, region_mass_, inverse_regions_;
  std::array<Array, 4> rotation_;
  bool turned_before_ = false;
  Affine affine_, scratch_;
};

}  // namespace mss
