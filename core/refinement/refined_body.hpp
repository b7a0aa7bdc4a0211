#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/refinement/refinement.hpp"

namespace mss {

/// A particle of smaller cells on the surface of larger ones, where it hangs: it is where its masters, one,
/// two or four particles of the larger cells, have it on average. It coincides with one of them or lies
/// amid an edge or a face.
struct HangingParticle {
  std::size_t level = 0;                    ///< its own; its masters' is the one before
  std::ptrdiff_t site = 0;                  ///< of its level's lattice
  std::array<std::ptrdiff_t, 4> masters{};  ///< sites of theirs
  std::size_t count = 1;                    ///< of masters

  /// Of each master.
  double weight() const { return 1.0 / double(count); }
};

/// A body whose cells are smaller in some places: nested lattices, each an ordinary Body of the cells of one
/// size. Immutable.
///
/// Positions x of hanging particles are T x of the particles that move, T being the averages over masters;
/// the forces on them go to their masters by T^T, and so do their masses, as row sums of T^T M T: T
/// reproduces affine maps, so mass, centre of mass, momentum and angular momentum are those of the particles
/// that move. Since (T x)_i^2 is at most the mean of the masters' x^2, no frequency exceeds the largest of
/// the lattices alone. Fields have the lattices' sites, one lattice after the other, the largest cells first.
///
/// Uniform strain is an equilibrium with t = 1 (springs along edges and faces). Body diagonals have forces at
/// the corners of a block of smaller cells, sheared, that equal cells would cancel: there it errs by the
/// square of the cell size.
class RefinedBody {
 public:
  /// Balances the map. Throws InputError for sharing `uniform`, for weights, for cells that are filled
  /// unevenly, and for more sites than fit.
  RefinedBody(const BodyConfig& config, RefinementMap map);

  /// The body without the refinement.
  const BodyConfig& config() const { return config_; }
  const RefinementMap& map() const { return map_; }
  /// At least one; cells of the next one are smaller, by a factor of two where they touch.
  const std::vector<Level>& levels() const { return levels_; }
  /// How often the cells of a level have been split.
  int depth(std::size_t level) const { return depths_[level]; }

  /// Sites of a field.
  std::ptrdiff_t size() const { return std::ptrdiff_t(mass_.size()); }
  /// Sites of the particles that move, ascending: the particle's id is its index in this list.
  const std::vector<std::ptrdiff_t>& sites() const { return sites_; }
  /// By level.
  const std::vector<HangingParticle>& hanging() const { return hanging_; }
  /// With its share of hanging particles' masses [kg]; 0 at a site without a particle that moves.
  double mass(std::ptrdiff_t site) const { return mass_[std::size_t(site)]; }
  double total_mass() const { return total_mass_; }
  std::size_t cell_count() const;

  /// The cell at a site of a level, as the map counts them.
  RefinementMap::Cell cell(std::size_t level, std::ptrdiff_t site) const;
  /// Of a site of a level, in fields.
  std::ptrdiff_t site_in_field(std::size_t level, std::ptrdiff_t site) const {
    return levels_[level].first + site;
  }
  /// T: puts hanging particles where their masters have them, in a field of positions or velocities.
  template <class Real>
  void interpolate(Field<Real>& field) const;
  /// T^T: adds the forces on hanging particles to their masters', and zeroes them.
  template <class Real>
  void scatter_to_masters(Field<Real>& forces) const;

 private:
  void add_level(int depth);
  void find_hanging(std::size_t level);
  void find_masses();

  BodyConfig config_;
  RefinementMap map_;
  std::vector<std::unique_ptr<const Body>> bodies_;
  std::vector<Level> levels_;
  std::vector<int> depths_;
  std::vector<RefinementMap::Cell> corners_;  ///< of each level's lattice, the lower one, in its cells
  std::vector<HangingParticle> hanging_;
  std::vector<std::ptrdiff_t> sites_;
  std::vector<double> mass_;  ///< per site
  double total_mass_ = 0;
};

}  // namespace mss
