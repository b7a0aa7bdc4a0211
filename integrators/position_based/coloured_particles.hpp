#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/springs/spring_system.hpp"
#include "integrators/position_based/coloured_lattice.hpp"
#include "integrators/position_based/xpbd_kernel.hpp"

namespace mss {

/// The particles of a body in the layout of a ColouredLattice, and the beginning and end of steps whose
/// unknowns are their displacements u = x - x_n.
template <class Real>
class ColouredParticles {
 public:
  /// The body of `springs` and `system`, whose threads do the work, must outlive it.
  ColouredParticles(const SpringSystem<Real>& springs, System<Real>& system);

  const Body& body() const { return body_; }
  const ColouredLattice& lattice() const { return lattice_; }

  /// Takes over positions and velocities.
  void load_state(const State<Real>& state);
  /// And accelerations that are constant during steps; those of held coordinates do not count.
  void load_acceleration(const Field<Real>& acceleration);
  /// Writes the positions and velocities of all particles.
  void store_state(State<Real>& state) const;

  /// Begins a step: u = dt v, and the target is where particles would be without springs, dt v + dt^2 a. It
  /// may be displacement().
  void predict(double dt, Field<Real>& target);
  /// finish(), then predict() with the same accelerations, in one; velocities are not kept.
  void proceed(double dt, Field<Real>& target);
  /// The same in one plane of the parts with that parity of z.
  void proceed(double dt, Field<Real>& target, int parity, std::ptrdiff_t plane);
  /// The displacement of a particle in this step [m].
  void set_displacement(std::ptrdiff_t site, int axis, Real u);
  /// Ends a step: x += u, v = u / dt.
  void finish(double dt);

  /// Before the step.
  ConstStreams<Real> before() const;
  ConstStreams<Real> velocity_before() const;
  Streams<Real> moved();
  Field<Real>& displacement() { return u_; }
  /// 0 along axes that are held, and where there is no particle [1/kg].
  ConstStreams<Real> inverse_mass() const;
  /// 1 along the axes in which nothing prescribes where a particle is, by index.
  Vec3 free_axes(std::ptrdiff_t index) const {
    return (inverse_mass_.at(index).array() > 0).template cast<double>();
  }
  /// Whether some particle is held along some axes only.
  bool partly_held() const { return partly_held_; }

  /// Where every particle is.
  const std::vector<std::ptrdiff_t>& index() const { return index_; }
  /// The distinct inverse masses, 0 first: of particles held along all axes, and where there is none.
  const std::vector<double>& masses() const { return masses_; }
  /// Which of them an index has.
  std::uint32_t mass_kind(std::ptrdiff_t index) const { return mass_kind_[std::size_t(index)]; }

 private:
  void find_masses(const HeldSites& held);
  /// Calls visit(index, site, count) for every second site of every row: `count` of them, from `site` on,
  /// have the indices from `index` on. Sites without a particle, which stay as they are, are among them.
  template <class Visit>
  void for_each_half_row(Visit&& visit) const;
  using StepPass = void (*)(const ProjectionStep<Real>&);
  /// Over one plane of the parts with that parity of z, and over all, on the system's threads.
  void pass_over_plane(double dt, Field<Real>& target, int parity, std::ptrdiff_t plane, StepPass pass);
  void pass_over_all(double dt, Field<Real>& target, StepPass pass);

  const Body& body_;
  System<Real>& system_;
  const XpbdKernel<Real>& kernel_;
  ColouredLattice lattice_;
  std::vector<std::ptrdiff_t> index_;     ///< of every particle
  std::vector<std::uint32_t> mass_kind_;  ///< per index
  std::vector<double> masses_{0};
  bool partly_held_ = false;
  Field<Real> x_, v_, u_, acceleration_, inverse_mass_;
};

/// What a kernel that works on W neighbouring indices of a part must be told of them: `lane_size` numbers a
/// lane, on which its coefficients depend beside the step. Equal blocks share an entry of a dictionary.
class ColouredBlocks {
 public:
  /// A lane's numbers, of the site (i, j, k) that is at `within` its part.
  using Describe = std::function<void(int colour, const std::array<int, 3>& site, std::ptrdiff_t within,
                                      std::uint32_t* numbers)>;
  /// All zeros are lanes with nothing to do; blocks of such lanes have entry 0.
  ColouredBlocks(const ColouredLattice& lattice, int lanes, int lane_size, const Describe& describe);

  /// Per block of a colour's part: which entry. Empty: the colour has no sites.
  const std::vector<std::uint32_t>& entries(int colour) const { return entries_[std::size_t(colour)]; }
  /// Number of entries, the empty one included.
  std::size_t size() const { return blocks_.size(); }
  const std::uint32_t* lane(std::size_t entry, int lane) const {
    return blocks_[entry].data() + std::size_t(lane) * std::size_t(lane_size_);
  }

 private:
  using Block = std::vector<std::uint32_t>;
  int lane_size_;
  std::array<std::vector<std::uint32_t>, ColouredLattice::colours> entries_;
  std::vector<Block> blocks_{Block{}};
};

/// Calls visit(colour, first, last), cells or particles [first, last) of a colour's part, for all colours in
/// ascending order, on the system's threads. Colours 0 to 3, those of even planes, touch a pair of planes
/// that no other pair's do, and so do 4 to 7: so a pair gets its four colours one after the other, while it
/// is in the cache, and what comes out is the same as if every colour were finished before the next.
///
/// Calls finished(parity, plane) once no remaining cell has a corner in that plane of the parts with that
/// parity of z.
template <class Real, class Visit, class Finished>
void for_each_colour(System<Real>& system, const ColouredLattice& lattice, const ColouredBlocks& blocks,
                     int lanes, Visit&& visit, Finished&& finished) {
  const auto visit_pair = [&](int lowest, std::ptrdiff_t plane) {
    for (int colour = lowest; colour < lowest + 4; ++colour)
      if (!blocks.entries(colour).empty())
        visit(colour, plane * lattice.plane, plane * lattice.plane + lattice.used(lanes));
  };
  system.parallel(lattice.planes(0), [&](std::ptrdiff_t plane) {
    visit_pair(0, plane);
    if (plane == 0) finished(0, plane);
  });
  system.parallel(lattice.planes(4), [&](std::ptrdiff_t plane) {
    visit_pair(4, plane);
    finished(1, plane);
    if (plane + 1 < lattice.planes(0)) finished(0, plane + 1);
  });
}

}  // namespace mss
