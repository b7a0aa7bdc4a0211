#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/body/body_config.hpp"
#include "core/body/spring_slots.hpp"

namespace mss {

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

/// What the 27 cells around a site hold, x first; its own is in the middle. Numbers of contents, from 1; 0:
/// no cell.
using CellsAround = std::array<std::uint32_t, 27>;

/// Whether some of these cells touch the site, so that a particle is there.
bool touch_site(const CellsAround& cells);

/// The kinds of sites that a body has, and what springs, dampers and masses are there. All of it follows from
/// what the 27 cells around a site hold, so sites with equal neighbourhoods are of one kind. Kind 0: no cell
/// touches the site.
///
/// A cell gives a spring the share of what is filled of it there: an edge that of its quarter, the mean of
/// the octants at the edge's ends, a face diagonal that of the half at its face, a body diagonal that of the
/// whole cell, f, which scales k_vol and k_g too. Uniform strain so gives f sigma in every cell. Its corners
/// get mass by the trilinear weights of what is filled. Several parts in a cell add up, each with its own
/// constants; dampers of a spring are the mean of what each part's law gives the spring, by shares of its
/// stiffness.
///
/// A sheet or a rope is a layer or a row of a solid that is repeated along its flat axes without end, of
/// which springs along these are left out; and it has no cells.
class SiteKinds {
 public:
  /// Of a body that must outlive these, and whose contents are valid when the first kind is added. Has kind 0
  /// alone.
  explicit SiteKinds(const BodyConfig& config);

  /// Those of the cells around a site that its kind depends on; 0 in place of the others.
  CellsAround relevant(const CellsAround& cells) const;
  /// Adds the kind of a neighbourhood: its number is size() before.
  void add(const CellsAround& cells);

  std::size_t size() const { return weights_.size(); }
  /// By kind.
  const std::vector<SiteWeights>& weights() const { return weights_; }
  SiteElements elements(std::uint32_t kind) const;

  /// Stiffness of a spring of a kind's sites [N/m]; 0 where there is none.
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

 private:
  /// Stiffness of springs by class [N/m], and k_vol and k_g [Pa].
  struct Constants {
    std::array<double, 3> spring{};
    double volume = 0, fold_guard = 0, shear_modulus = 0;
  };
  struct Shares;

  void find_constants();
  void find_damping_time();
  Shares shares_of(const CellsAround& cells, int part) const;
  void add_weights_of(const Shares& shares, std::size_t part, SiteWeights& w) const;
  std::array<double, spring_slots.size()> dampings_of(const std::vector<Shares>& shares) const;
  double mass_of_full_corner(std::size_t part) const;

  const BodyConfig& config_;
  std::vector<Part> parts_;
  double springs_floor_, mass_floor_;
  std::vector<Constants> constants_;  ///< by part
  Constants interior_;
  std::uint32_t relevant_;            ///< which of the 27 cells a kind depends on, as bits
  std::vector<SiteWeights> weights_;  ///< by kind
  std::optional<double> damping_time_{};
  /// By kind [kg/s], if there is no such time.
  std::vector<std::array<double, spring_slots.size()>> dampings_;
};

}  // namespace mss
