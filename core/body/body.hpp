#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/communicator.hpp"
#include "core/base/field.hpp"
#include "core/base/lattice.hpp"
#include "core/body/cell_fill.hpp"
#include "core/body/material.hpp"
#include "core/body/voxels.hpp"

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
/// three faces, and the body diagonals. Of each group a slot.
inline constexpr int spring_groups = 7;
inline constexpr std::array<std::uint8_t, spring_groups> slot_of_group{0, 1, 2, 3, 4, 5, 9};

inline constexpr std::array<std::uint8_t, spring_slots.size()> group_of_slot{0, 1, 2, 3, 4, 5, 3,
                                                                             4, 5, 6, 6, 6, 6};

/// What a site contributes, over what an interior site does, and the mass of its particle.
struct SiteWeights {
  std::array<double, spring_groups> spring{};  ///< stiffness, by group
  double volume = 0;                           ///< k_vol of its cell
  double fold_guard = 0;                       ///< k_g of its cell
  double fill = 0;                             ///< filled share f of its cell
  double mass = 0;                             ///< of the cells' shares at the particle [kg]; 0: no particle
  std::uint32_t content = 0;                   ///< of its cell, from 1; 0: no cell
};

/// The same as numbers: the stiffness and damping of a site's thirteen springs, and of its cell.
struct SiteElements {
  std::array<double, spring_slots.size()> stiffness{};  ///< [N/m]; 0 where there is no spring
  std::array<double, spring_slots.size()> damping{};    ///< [kg/s]
  double volume = 0;                                    ///< k_vol of the cell [Pa]; 0 where there is no cell
  double fold_guard = 0;                                ///< k_g of the cell [Pa]; the same
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

/// A material that a body has in some of its cells.
struct Part {
  std::string name{};
  double density = 1000;                      ///< [kg/m^3]
  SpringConstants springs{};                  ///< of springs inside it
  std::optional<ElasticConstants> elastic{};  ///< the material they model, if any
  Damping damping{};
};

/// Everything that defines a body at rest.
struct BodyConfig {
  VoxelGrid voxels = VoxelGrid::box(1, 1, 1);
  /// What cells hold: a table of distinct contents, and by VoxelGrid::index() which of these a cell has. Both
  /// empty: every cell is full of part 0. With Sharing::weighted only. See Body for what they do.
  std::vector<CellContent> contents{};
  std::vector<std::uint32_t> content_of{};
  /// Floors a and b that keep nearly empty corners from being light or weak: springs take
  /// a f + (1 - a) times the filled share at them, corners b f + (1 - b) times theirs; f is the cell's share.
  /// By default a = 0.3, b = 0.35, chosen on the sphere of `mss shape`. Where k_vol is negative
  /// a cell with strong springs at few corners is unstable: there both are 0.4.
  std::optional<double> fill_blend_springs{};
  std::optional<double> fill_blend_mass{};
  double cell_size = 1;  ///< h [m]
  Vec3 origin = Vec3::Zero();
  Topology topology = Topology::full;
  Sharing sharing = Sharing::weighted;
  double density = 1000;  ///< of part 0, as the next three [kg/m^3]
  std::vector<Weight> weights{};
  SpringConstants springs{};                  ///< of interior springs
  std::optional<ElasticConstants> elastic{};  ///< the material they model, if any
  Damping damping{};
  double fold_guard = 0;      ///< k_g over a part's shear modulus; 0: no guard against folding
  std::vector<Part> parts{};  ///< 1, 2, ...

  /// Fills the cells with a material: elastic constants, and springs calibrated for them.
  void fill(const ElasticConstants& material, double face_share) {
    elastic = material;
    springs = calibrate(material, cell_size, face_share);
  }
  /// C44 of the interior springs of part 0 [Pa].
  double shear_modulus() const { return cubic_stiffness(springs, cell_size).c44; }

  /// Part 0, whose name is empty, and `parts`.
  std::vector<Part> all_parts() const {
    std::vector<Part> all{{{}, density, springs, elastic, damping}};
    all.insert(all.end(), parts.begin(), parts.end());
    return all;
  }
  /// Whether some part has a property.
  template <class Property>
  bool any_part(Property&& property) const {
    const std::vector<Part> all = all_parts();
    return std::any_of(all.begin(), all.end(), property);
  }
  bool has_volume_force() const {
    return any_part([](const Part& part) { return part.springs.volume != 0; });
  }
  /// Below Poisson's ratio 1/4: energies then have no lower bound.
  bool has_negative_volume_stiffness() const {
    return any_part([](const Part& part) { return part.springs.volume < 0; });
  }
  double springs_floor() const {
    return fill_blend_springs.value_or(has_negative_volume_stiffness() ? 0.4 : 0.3);
  }
  double mass_floor() const { return fill_blend_mass.value_or(has_negative_volume_stiffness() ? 0.4 : 0.35); }
  bool is_damped() const {
    return any_part([](const Part& part) { return part.damping.law != Damping::Law::none; });
  }
  /// Whether every cell is full of part 0.
  bool is_full() const;
};

/// Splits or merges cells: of each `before` in a row, which are alike, become `after`, as full as they were.
/// For cells that are filled evenly.
void resample(BodyConfig& body, int before, int after);

/// Share of a full corner's mass that a fill gives a corner; `floor` is BodyConfig::mass_floor().
double corner_share(const CellFill& fill, int corner, double floor);

/// A body at rest: cells, particles, masses and springs on a lattice. Immutable.
///
/// Springs are not stored. Whether a spring exists, its shared stiffness and its damping follow from what the
/// 3 x 3 x 3 cells around its site hold, so sites with equal neighbourhoods share one SiteWeights.
///
/// A cell gives a spring the share of what is filled of it there: an edge that of its quarter, the mean of
/// the octants at the edge's ends, a face diagonal that of the half at its face, a body diagonal that of the
/// whole cell, f, which scales k_vol and k_g too. Uniform strain so gives f sigma in every cell. Its corners
/// get mass by the trilinear weights of what is filled. Several parts in a cell add up, each with its own
/// constants; dampers of a spring are the mean of what each part's law gives the spring, by shares of its
/// stiffness.
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

  const BodyConfig& config() const { return config_; }
  const Lattice& lattice() const { return lattice_; }
  /// Those that share the body.
  const Communicator& ranks() const { return ranks_; }
  /// Of lattice(), without ghosts.
  PlaneRange own_planes() const { return own_; }
  /// Part 0 first.
  const std::vector<Part>& parts() const { return parts_; }
  /// What the cell at a site holds; there must be one.
  const CellContent& content_at(std::ptrdiff_t site) const { return content_of(weights_at(site).content); }

  std::size_t cell_count() const { return cells_; }
  std::size_t particle_count() const { return site_of_.size(); }
  std::size_t spring_count() const { return springs_; }
  double total_mass() const { return mass_of_cells_ + all_weights_; }
  /// Of what is filled at rest [m^3].
  double volume() const { return cell_volume() * filled_cells_; }
  double cell_volume() const { return config_.cell_size * config_.cell_size * config_.cell_size; }

  /// Lattice site of every particle, ascending: the particle's id is its index in this list.
  const std::vector<std::ptrdiff_t>& sites() const { return site_of_; }
  /// The reverse: id of the particle at a site; -1 where there is none.
  int particle(std::ptrdiff_t site) const { return particle_[std::size_t(site)]; }

  /// Mass of the particle at a site [kg]; 0 where there is none. Eq. 2-2, and its share of weights.
  double mass(std::ptrdiff_t site) const {
    const double cells = weights_at(site).mass;
    return weight_.empty() ? cells : cells + weight_[std::size_t(site)];
  }

  /// Position at rest [m]; defined for every site, ghosts included.
  Vec3 rest_position(std::ptrdiff_t site) const;

  /// Rest length of a spring class [m].
  double rest_length(SpringSlot::Class kind) const {
    return config_.cell_size * length_factor_[static_cast<std::size_t>(kind)];
  }

  /// Which of weights() a site has.
  std::uint32_t element_kind(std::ptrdiff_t site) const { return kind_[std::size_t(site)]; }
  const std::vector<SiteWeights>& weights() const { return weights_; }
  const SiteWeights& weights_at(std::ptrdiff_t site) const { return weights_[element_kind(site)]; }
  SiteElements elements(std::uint32_t kind) const;
  SiteElements elements_at(std::ptrdiff_t site) const { return elements(element_kind(site)); }

  /// Stiffness of a site's spring [N/m]; 0 where there is none.
  double stiffness(std::uint32_t kind, std::size_t slot) const {
    return weights_[kind].spring[group_of_slot[slot]] * interior_stiffness(slot);
  }
  /// tau [s], if every spring's damping is c = tau k; 0: nothing damps.
  std::optional<double> damping_time() const { return damping_time_; }

  /// What weights multiply, part 0's or, where it has none, the largest of any part: the stiffness of an
  /// interior spring of a slot [N/m], 0 where the topology has none, and k_vol and k_g of a full cell [Pa].
  double interior_stiffness(std::size_t slot) const;
  double interior_volume() const { return interior_.volume; }
  double interior_fold_guard() const { return interior_.fold_guard; }

  bool has_cell(std::ptrdiff_t site) const { return weights_at(site).content != 0; }

  /// Calls visit(site_a, site_b, slot, stiffness, damping) for every spring, in site order.
  template <class Visit>
  void for_each_spring(Visit&& visit) const {
    for (std::ptrdiff_t site = lattice_.plane * own_.first; site < lattice_.plane * own_.last; ++site) {
      if (element_kind(site) == 0) continue;
      const SiteElements e = elements_at(site);
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
    for (std::ptrdiff_t site = lattice_.plane * own_.first; site < lattice_.plane * own_.last; ++site)
      if (has_cell(site)) visit(site);
  }

  /// Sites of the particles whose rest position lies in the closed box [lower, upper], widened by 1e-9 cell.
  std::vector<std::ptrdiff_t> select(const Vec3& lower, const Vec3& upper) const;

 private:
  /// Contents of the 27 cells around a site, from 1, x first; its own is in the middle. 0: no cell.
  using Neighbourhood = std::array<std::uint32_t, 27>;
  /// Stiffness of springs by class [N/m], and k_vol and k_g [Pa].
  struct Constants {
    std::array<double, 3> spring{};
    double volume = 0, fold_guard = 0, shear_modulus = 0;
  };
  struct Shares;

  bool is_own(int plane) const { return plane >= own_.first && plane < own_.last; }
  bool is_here(int plane) const { return plane >= 0 && plane < lattice_.planes(); }
  void check_contents() const;
  void check_content(std::size_t content) const;
  std::uint32_t content(int i, int j, int k) const;
  const CellContent& content_of(std::uint32_t content) const;
  void find_constants();
  void find_particles();
  void classify_sites();
  void check_masses() const;
  void add_weights();
  Shares shares_of(const Neighbourhood& cells, int part) const;
  void add_weights_of(const Shares& shares, std::size_t part, SiteWeights& w) const;
  void find_damping_time();
  void add_kind(const Neighbourhood& cells);
  std::array<double, spring_slots.size()> dampings_of(const std::vector<Shares>& shares) const;
  double mass_of_full_corner(std::size_t part) const { return parts_[part].density * cell_volume() / 8; }

  static constexpr std::array<double, 3> length_factor_{1.0, 1.4142135623730951, 1.7320508075688772};

  BodyConfig config_;
  const Communicator& ranks_;
  PlaneRange planes_;  ///< of the whole body's lattice: all that this one has
  PlaneRange own_;
  Lattice lattice_;
  std::vector<Part> parts_;
  std::vector<Constants> constants_;  ///< by part
  Constants interior_;
  double springs_floor_, mass_floor_;
  std::size_t cells_ = 0;
  double filled_cells_ = 0;   ///< shares of all cells, added
  double mass_of_cells_ = 0;  ///< [kg]
  std::size_t springs_ = 0;
  std::vector<double> weight_;  ///< per site, beside that of cells [kg]; empty: there are none
  double all_weights_ = 0;      ///< [kg]
  std::vector<std::ptrdiff_t> site_of_;
  std::vector<int> particle_;  ///< per site
  std::vector<std::uint32_t> kind_;
  std::vector<SiteWeights> weights_;  ///< by kind
  std::optional<double> damping_time_{};
  std::vector<std::array<double, spring_slots.size()>>
      dampings_;  ///< by kind [kg/s], if there is no such time
};

/// A lattice of a solid: its body, and where its sites begin in fields.
struct Level {
  const Body& body;
  std::ptrdiff_t first = 0;
};

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
