#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/field.hpp"
#include "core/lattice.hpp"
#include "core/material.hpp"
#include "core/voxels.hpp"

namespace mss {

/// A spring assigned to the cell at a site, as a pair of that cell's corners (c = bx + 2 by + 4 bz).
struct SpringSlot {
  enum class Class : std::uint8_t { edge, face, body };
  int a;
  int b;
  Class kind;
};

/// The thirteen springs per site: every spring of a body lies in exactly one slot of exactly one site.
inline constexpr std::array<SpringSlot, 13> spring_slots{{
    {0, 1, SpringSlot::Class::edge},
    {0, 2, SpringSlot::Class::edge},
    {0, 4, SpringSlot::Class::edge},
    {0, 3, SpringSlot::Class::face},  // the diagonals that `one_diagonal` keeps
    {0, 5, SpringSlot::Class::face},
    {0, 6, SpringSlot::Class::face},
    {1, 2, SpringSlot::Class::face},
    {1, 4, SpringSlot::Class::face},
    {2, 4, SpringSlot::Class::face},
    {0, 7, SpringSlot::Class::body},
    {1, 6, SpringSlot::Class::body},
    {2, 5, SpringSlot::Class::body},
    {3, 4, SpringSlot::Class::body},
}};

/// Springs of a site that the same cells share have equal weights: the three edges, the diagonals of the
/// three faces, and the body diagonals.
inline constexpr int spring_groups = 7;
inline constexpr std::array<std::uint8_t, 13> group_of{0, 1, 2, 3, 4, 5, 3, 4, 5, 6, 6, 6, 6};

/// What a site contributes: the stiffness and damping of its thirteen springs and the volume stiffness of its
/// cell.
struct SiteElements {
  /// Stiffness over that of interior springs, by group; the last is also the cell's, for k_vol and k_g.
  std::array<double, spring_groups> weight{};
  std::array<double, spring_slots.size()> stiffness{};  ///< [N/m]; 0 where there is no spring
  std::array<double, spring_slots.size()> damping{};    ///< [kg/s]
  double volume = 0;                                    ///< k_vol of the cell [Pa]; 0 where there is no cell
  double fold_guard = 0;                                ///< k_g of the cell [Pa]; the same
  double corner_fill = 0;  ///< fill factors of the cells at the particle, added; 0: no particle
};

/// A closed axis-aligned box in rest coordinates [m].
struct Box {
  Vec3 lower = Vec3::Zero();
  Vec3 upper = Vec3::Zero();
};

/// Mass in addition to that of the cells: the particles of a box share it equally. It has no influence on the
/// damping of springs.
struct Weight {
  Box box{};
  double mass = 0;  ///< of all together [kg]
};

/// Everything that defines a body at rest.
struct BodyConfig {
  VoxelGrid voxels = VoxelGrid::box(1, 1, 1);
  /// By VoxelGrid::index(), how much of a cell the material fills, in (0, 1]: it scales the cell's share of
  /// springs, its volume force and its mass. Empty: every cell is full. With Sharing::weighted only.
  std::vector<float> cell_fill{};
  double cell_size = 1;  ///< h [m]
  Vec3 origin = Vec3::Zero();
  Topology topology = Topology::full;
  Sharing sharing = Sharing::weighted;
  double density = 1000;  ///< [kg/m^3]
  std::vector<Weight> weights{};
  SpringConstants springs{};                  ///< of interior springs
  std::optional<ElasticConstants> elastic{};  ///< the material they model, if any
  Damping damping{};
  double fold_guard = 0;  ///< k_g over the shear modulus; 0: no guard against folding

  /// Fills the cells with a material: elastic constants, and springs calibrated for them.
  void fill(const ElasticConstants& material, double face_share) {
    elastic = material;
    springs = calibrate(material, cell_size, face_share);
  }
  /// C44 of the interior springs [Pa].
  double shear_modulus() const { return cubic_stiffness(springs, cell_size).c44; }
};

/// A body at rest: cells, particles, masses and springs on a lattice. Immutable.
///
/// Springs are not stored. Whether a spring exists, its shared stiffness and its damping follow from the fill
/// factors of the 3 x 3 x 3 cells around its site, so sites with equal neighbourhoods share one SiteElements.
class Body {
 public:
  /// Throws InputError for fill factors that are too few, not in (0, 1], or with Sharing::uniform.
  explicit Body(const BodyConfig& config);

  const BodyConfig& config() const { return config_; }
  const Lattice& lattice() const { return lattice_; }

  std::size_t cell_count() const { return cells_; }
  std::size_t particle_count() const { return site_of_.size(); }
  std::size_t spring_count() const { return springs_; }
  double total_mass() const { return config_.density * filled_cells_ * cell_volume() + all_weights_; }
  double cell_volume() const { return config_.cell_size * config_.cell_size * config_.cell_size; }

  /// Lattice site of every particle, ascending: the particle's id is its index in this list.
  const std::vector<std::ptrdiff_t>& sites() const { return site_of_; }
  /// The reverse: id of the particle at a site; -1 where there is none.
  int particle(std::ptrdiff_t site) const { return particle_[std::size_t(site)]; }

  /// Mass of the particle at a site [kg]; 0 where there is none. Eq. 2-2, and its share of weights.
  double mass(std::ptrdiff_t site) const {
    const double cells = eighth_mass_ * elements_at(site).corner_fill;
    return weight_.empty() ? cells : cells + weight_[std::size_t(site)];
  }

  /// Position at rest [m]; defined for every site, ghosts included.
  Vec3 rest_position(std::ptrdiff_t site) const;

  /// Rest length of a spring class [m].
  double rest_length(SpringSlot::Class kind) const {
    return config_.cell_size * length_factor_[static_cast<std::size_t>(kind)];
  }

  /// Which of elements() a site has.
  std::uint32_t element_kind(std::ptrdiff_t site) const { return kind_[std::size_t(site)]; }
  const std::vector<SiteElements>& elements() const { return elements_; }
  const SiteElements& elements_at(std::ptrdiff_t site) const { return elements_[element_kind(site)]; }

  /// Stiffness of an interior spring of a slot [N/m]; 0 where the topology has none.
  double interior_stiffness(std::size_t slot) const;
  /// k_g of a full cell [Pa].
  double interior_fold_guard() const;

  bool has_cell(std::ptrdiff_t site) const { return cell_[std::size_t(site)] != 0; }

  /// Calls visit(site_a, site_b, slot, stiffness, damping) for every spring, in site order.
  template <class Visit>
  void for_each_spring(Visit&& visit) const {
    for (std::ptrdiff_t site = 0; site < lattice_.sites; ++site) {
      const SiteElements& e = elements_at(site);
      for (std::size_t s = 0; s < spring_slots.size(); ++s) {
        if (e.stiffness[s] == 0) continue;
        const SpringSlot& slot = spring_slots[s];
        visit(site + lattice_.corner(slot.a), site + lattice_.corner(slot.b), slot, e.stiffness[s],
              e.damping[s]);
      }
    }
  }

  /// Calls visit(site) with the lower corner of every cell, in site order.
  template <class Visit>
  void for_each_cell(Visit&& visit) const {
    for (std::ptrdiff_t site = 0; site < lattice_.sites; ++site)
      if (has_cell(site)) visit(site);
  }

  /// Sites of the particles whose rest position lies in the closed box [lower, upper], widened by 1e-9 cell.
  std::vector<std::ptrdiff_t> select(const Vec3& lower, const Vec3& upper) const;

 private:
  /// Fill factors of the 27 cells around a site, x first; its own is in the middle.
  using Neighbourhood = std::array<float, 27>;

  void check_fill() const;
  float fill(int i, int j, int k) const;
  void find_particles();
  void classify_sites();
  void add_weights();
  SiteElements elements_from(const Neighbourhood& cells) const;

  static constexpr std::array<double, 3> length_factor_{1.0, 1.4142135623730951, 1.7320508075688772};

  BodyConfig config_;
  Lattice lattice_;
  double eighth_mass_;  ///< rho h^3 / 8 [kg]
  std::size_t cells_ = 0;
  double filled_cells_ = 0;  ///< fill factors of all cells, added
  std::size_t springs_ = 0;
  std::vector<std::uint8_t> cell_;  ///< per site: 1 where a cell has its lower corner
  std::vector<double> weight_;      ///< per site, beside that of cells [kg]; empty: there are none
  double all_weights_ = 0;          ///< [kg]
  std::vector<std::ptrdiff_t> site_of_;
  std::vector<int> particle_;  ///< per site
  std::vector<std::uint32_t> kind_;
  std::vector<SiteElements> elements_;
};

/// Positions of the eight corners c = bx + 2 by + 4 bz of the cell at a site.
template <class Real>
std::array<Vec3, 8> corners_of(const Body& body, const Field<Real>& x, std::ptrdiff_t site) {
  std::array<Vec3, 8> corners;
  for (int c = 0; c < 8; ++c) corners[std::size_t(c)] = x.at(site + body.lattice().corner(c));
  return corners;
}

}  // namespace mss
