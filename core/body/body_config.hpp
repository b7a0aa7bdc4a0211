#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/field.hpp"
#include "core/body/cell_fill.hpp"
#include "core/body/material.hpp"
#include "core/body/relaxation.hpp"
#include "core/body/spring_slots.hpp"
#include "core/body/voxels.hpp"

namespace mss {

/// A closed axis-aligned box in rest coordinates [m].
struct Box {
  Vec3 lower = Vec3::Zero();
  Vec3 upper = Vec3::Zero();
};

/// Added mass, beside that of the cells: the particles of a box share it equally. It has no influence on the
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
  /// What a body is along its flat axes [m]: a sheet's thickness, the edge of a rope's square section. Empty:
  /// cell_size.
  std::optional<double> thickness{};
  Vec3 origin = Vec3::Zero();
  Topology topology = Topology::full;
  Sharing sharing = Sharing::weighted;
  double density = 1000;  ///< of part 0, as the next three [kg/m^3]
  std::vector<Weight> weights{};
  SpringConstants springs{};                  ///< of interior springs
  std::optional<ElasticConstants> elastic{};  ///< the material they model, if any
  Damping damping{};
  Relaxation relaxation{};    ///< of all parts' springs
  double fold_guard = 0;      ///< k_g over a part's shear modulus; 0: no guard against folding
  std::vector<Part> parts{};  ///< 1, 2, ...

  /// Whether it has cells of three dimensions; else it is a sheet or a rope, which resist neither bending nor
  /// twist, and have no volume.
  bool is_solid() const { return voxels.dimensions() == 3; }
  /// "a body", "a sheet" or "a rope", for the user.
  const char* noun() const;
  double across() const { return thickness.value_or(cell_size); }

  /// Springs calibrated for a material. Those of sheets and ropes have its E alone:
  ///   a rope of area A = thickness^2  k_e = E A / h;
  ///   a sheet in plane stress         k_e = 3/4 E thickness, k_f = 3/8 E thickness, and nu = 1/3, as central
  ///                                   forces make C12 = C44.
  SpringConstants calibrated(const ElasticConstants& material, double face_share) const;
  /// Fills the cells with a material: elastic constants, and springs calibrated for them.
  void fill(const ElasticConstants& material, double face_share) {
    elastic = material;
    springs = calibrated(material, face_share);
  }
  /// C44 of interior springs [Pa]; of a rope, which has none, E/3, so that a viscosity of shear eta is one of
  /// extension of 3 eta, Trouton's.
  double shear_modulus_of(const SpringConstants& springs) const;
  /// Young's modulus along an axis that interior springs make [Pa].
  double young_of(const SpringConstants& springs, int axis) const;
  /// Of part 0.
  double shear_modulus() const { return shear_modulus_of(springs); }

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
  /// Number of what the cell (i, j, k) holds, from 1; 0 where there is no cell.
  std::uint32_t content_at(int i, int j, int k) const;
  const CellContent& content(std::uint32_t number) const;
  /// Rest length of a spring class [m].
  double rest_length(SpringSlot::Class kind) const { return cell_size * length_over_edge(kind); }
  /// Of a cell [m^3]; of sheets and ropes that of a square or a link with what it is across.
  double cell_volume() const {
    double volume = 1;
    for (const int cells : voxels.size()) volume *= cells == 0 ? across() : cell_size;
    return volume;
  }
};

/// Throws InputError for contents that are too few, empty, of an unknown part, fuller than a cell, or with
/// Sharing::uniform.
void check_contents(const BodyConfig& body);

/// Splits or merges cells: of each `before` in a row, which are alike, become `after`, as full as they were.
/// For cells that are filled evenly.
void resample(BodyConfig& body, int before, int after);

}  // namespace mss
