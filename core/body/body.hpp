#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/communicator.hpp"
#include "core/base/field.hpp"
#include "core/base/lattice.hpp"
#include "core/body/body_config.hpp"
#include "core/body/site_kinds.hpp"

namespace mss {

/// A body at rest: cells, particles, masses and springs on a lattice. Immutable.
///
/// Of fewer dimensions, see VoxelGrid, it is a sheet or a rope: it has squares or links in place of cells,
/// what springs lie in them, and nothing that cells have, such as a volume or a guard against folding.
///
/// Springs are not stored: which there are at a site, and how stiff, follows from its kind, see SiteKinds.
///
/// Where several ranks share a body, each has a slab of its planes: its lattice is these and a ghost plane on
/// each side where another rank goes on. Particles, springs and cells it calls its own, with their sites, are
/// those at its own planes; what is known of elements at a site holds for ghosts too. Numbers of cells and
/// springs, mass, volume and the kinds of sites are those of the whole.
class Body {
 public:
  /// Throws InputError for contents that are too few, empty, of an unknown part, fuller than a cell, or with
  /// Sharing::uniform, for particles without mass, and for more ranks, which must outlive it, than planes.
  explicit Body(const BodyConfig& config, const Communicator& ranks = Communicator::alone());
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  const BodyConfig& config() const { return config_; }
  const Lattice& lattice() const { return lattice_; }
  /// Those that share the body.
  const Communicator& ranks() const { return ranks_; }
  /// Of lattice(), without ghosts.
  PlaneRange own_planes() const { return own_; }
  /// Part 0 first.
  const std::vector<Part>& parts() const { return parts_; }
  /// What the cell at a site holds; there must be one.
  const CellContent& content_at(std::ptrdiff_t site) const {
    return config_.content(weights_at(site).content);
  }

  /// Of a sheet its squares, of a rope its links.
  std::size_t cell_count() const { return cells_; }
  std::size_t particle_count() const { return site_of_.size(); }
  std::size_t spring_count() const { return springs_; }
  double total_mass() const { return mass_of_cells_ + all_added_mass_; }
  /// Of what is filled at rest [m^3]; of sheets and ropes with what they are across.
  double volume() const { return cell_volume() * filled_cells_; }
  double cell_volume() const { return config_.cell_volume(); }

  /// Lattice site of every particle, ascending: the particle's id is its index in this list.
  const std::vector<std::ptrdiff_t>& sites() const { return site_of_; }
  /// The reverse: id of the particle at a site; -1 where there is none.
  int particle(std::ptrdiff_t site) const { return particle_[std::size_t(site)]; }

  /// Mass of the particle at a site [kg]; 0 where there is none. Eq. 2-2, and its share of weights.
  double mass(std::ptrdiff_t site) const {
    const double cells = weights_at(site).mass;
    return added_mass_.empty() ? cells : cells + added_mass_[std::size_t(site)];
  }

  /// Position at rest [m]; defined for every site, ghosts included.
  Vec3 rest_position(std::ptrdiff_t site) const;

  /// Rest length of a spring class [m].
  double rest_length(SpringSlot::Class kind) const { return config_.rest_length(kind); }

  /// What springs and cells the sites have, by kind; and which kind a site is of.
  const SiteKinds& kinds() const { return kinds_; }
  std::uint32_t kind(std::ptrdiff_t site) const { return kind_[std::size_t(site)]; }
  const SiteWeights& weights_at(std::ptrdiff_t site) const { return kinds_.weights()[kind(site)]; }
  SiteElements elements_at(std::ptrdiff_t site) const { return kinds_.elements(kind(site)); }

  bool has_cell(std::ptrdiff_t site) const { return weights_at(site).content != 0; }

  /// Calls visit(site_a, site_b, slot, stiffness, damping) for every spring, in site order.
  template <class Visit>
  void for_each_spring(Visit&& visit) const {
    for (std::ptrdiff_t site = lattice_.plane * own_.first; site < lattice_.plane * own_.last; ++site) {
      if (kind(site) == 0) continue;
      const SiteElements e = elements_at(site);
      for (std::size_t s = 0; s < spring_slots.size(); ++s) {
        if (e.stiffness[s] == 0) continue;
        const SpringSlot& slot = spring_slots[s];
        visit(site + lattice_.corner(slot.a), site + lattice_.corner(slot.b), slot, e.stiffness[s],
              e.damping[s]);
      }
    }
  }

  /// Corners of a cell, of a square of a sheet or of a link of a rope: 8, 4 or 2 of c = bx + 2 by + 4 bz.
  const std::vector<int>& corners() const { return corners_; }

  /// Calls visit(site) with the lower corner of every cell, square or link, in site order.
  template <class Visit>
  void for_each_piece(Visit&& visit) const {
    for (std::ptrdiff_t site = lattice_.plane * own_.first; site < lattice_.plane * own_.last; ++site) {
      if (kind(site) == 0) continue;
      const auto [i, j, k] = lattice_.coordinates(site);
      if (config_.voxels.at(i, j, k + planes_.first)) visit(site);
    }
  }

  /// Calls visit(site) with the lower corner of every cell, in site order; sheets and ropes have none.
  template <class Visit>
  void for_each_cell(Visit&& visit) const {
    for (std::ptrdiff_t site = lattice_.plane * own_.first; site < lattice_.plane * own_.last; ++site)
      if (has_cell(site)) visit(site);
  }

  /// Sites of the particles whose rest position lies in the closed box [lower, upper], widened by 1e-9 cell.
  std::vector<std::ptrdiff_t> select(const Vec3& lower, const Vec3& upper) const;

 private:
  bool is_own(int plane) const { return plane >= own_.first && plane < own_.last; }
  bool is_here(int plane) const { return plane >= 0 && plane < lattice_.planes(); }
  void find_particles();
  void classify_sites();
  void check_masses() const;
  void find_added_masses();

  BodyConfig config_;
  const Communicator& ranks_;
  PlaneRange planes_;  ///< of the whole body's lattice: all that this one has
  PlaneRange own_;
  Lattice lattice_;
  std::vector<int> corners_;
  std::vector<Part> parts_;
  SiteKinds kinds_;
  std::size_t cells_ = 0;
  double filled_cells_ = 0;   ///< shares of all cells, added
  double mass_of_cells_ = 0;  ///< [kg]
  std::size_t springs_ = 0;
  std::vector<double> added_mass_;  ///< per site, beside that of cells [kg]; empty: there are none
  double all_added_mass_ = 0;       ///< [kg]
  std::vector<std::ptrdiff_t> site_of_;
  std::vector<int> particle_;  ///< per site
  std::vector<std::uint32_t> kind_;
};

/// A lattice of a solid: its body, and where its sites begin in fields.
struct Level {
  const Body& body;
  std::ptrdiff_t first = 0;
};

/// Copies what is a level's between a field of the whole and one of the level.
template <class Real>
void copy_level(const Field<Real>& whole, const Level& level, Field<Real>& part);
template <class Real>
void copy_level(const Level& level, const Field<Real>& part, Field<Real>& whole);

/// Sites in fields of the particles whose rest position lies in a closed box, widened by 1e-9 cell.
std::vector<std::ptrdiff_t> select(const std::vector<Level>& levels, const Box& box);

/// Positions of the eight corners c = bx + 2 by + 4 bz of the cell at a site.
template <class Real>
std::array<Vec3, 8> corners_of(const Body& body, const Field<Real>& x, std::ptrdiff_t site) {
  std::array<Vec3, 8> corners;
  for (int c = 0; c < 8; ++c) corners[std::size_t(c)] = x.at(site + body.lattice().corner(c));
  return corners;
}

}  // namespace mss
