#pragma once

#include <array>
#include <span>
#include <string_view>

#include "core/springs/solid_system.hpp"

namespace mss {

/// Measures of a body at one moment: a row of series.csv.
struct Measures {
  double t = 0;                    ///< [s]
  double kinetic = 0;              ///< [J]
  double elastic = 0;              ///< of springs and the guard against folding, or of finite elements [J]
  double volume_energy = 0;        ///< eq. 3-1 summed over cells [J]
  bool relaxes = false;            ///< whether there are Maxwell branches: the next two are of them
  double relaxing = 0;             ///< energy stored in them [J]
  double relaxed = 0;              ///< what their dampers have dissipated [J]
  double external_potential = 0;   ///< potential of gravity, from z = 0, of loads and of penalty planes [J]
  double volume_ratio = 1;         ///< exact volume of what is filled over that at rest
  double volume_ratio_thesis = 1;  ///< the same with eq. 3-5, 3-6
  Vec3 momentum = Vec3::Zero();    ///< [kg m/s]
  Vec3 angular_momentum = Vec3::Zero();  ///< about the centre of mass [kg m^2/s]
  double max_speed = 0;                  ///< [m/s]
  double max_stretch = 0;                ///< largest | |d|/L0 - 1 | of a spring
  double min_jacobian = 1;               ///< smallest signed volume of a cell corner's three edges, over h^3

  /// Kinetic and stored energy of the body itself [J].
  double mechanical() const { return kinetic + elastic + volume_energy + relaxing; }
  double total() const { return mechanical() + external_potential; }

  /// See core/base/record.hpp.
  void remember(Record& record);
};

/// A number among the measures, as series.csv names it.
struct MeasureColumn {
  std::string_view name;
  std::string_view unit;  ///< empty: a ratio
  double (*value)(const Measures&);
};
inline constexpr std::array<MeasureColumn, 19> measure_columns{{
    {"t", "s", [](const Measures& m) { return m.t; }},
    {"kinetic", "J", [](const Measures& m) { return m.kinetic; }},
    {"elastic", "J", [](const Measures& m) { return m.elastic; }},
    {"volume_energy", "J", [](const Measures& m) { return m.volume_energy; }},
    {"external_potential", "J", [](const Measures& m) { return m.external_potential; }},
    {"total", "J", [](const Measures& m) { return m.total(); }},
    {"volume_ratio", "", [](const Measures& m) { return m.volume_ratio; }},
    {"volume_ratio_paper", "", [](const Measures& m) { return m.volume_ratio_thesis; }},
    {"momentum_x", "kg m/s", [](const Measures& m) { return m.momentum[0]; }},
    {"momentum_y", "kg m/s", [](const Measures& m) { return m.momentum[1]; }},
    {"momentum_z", "kg m/s", [](const Measures& m) { return m.momentum[2]; }},
    {"angular_momentum_x", "kg m^2/s", [](const Measures& m) { return m.angular_momentum[0]; }},
    {"angular_momentum_y", "kg m^2/s", [](const Measures& m) { return m.angular_momentum[1]; }},
    {"angular_momentum_z", "kg m^2/s", [](const Measures& m) { return m.angular_momentum[2]; }},
    {"max_speed", "m/s", [](const Measures& m) { return m.max_speed; }},
    {"max_stretch", "", [](const Measures& m) { return m.max_stretch; }},
    {"min_jacobian", "", [](const Measures& m) { return m.min_jacobian; }},
    {"relaxing_energy", "J", [](const Measures& m) { return m.relaxing; }},
    {"relaxed_energy", "J", [](const Measures& m) { return m.relaxed; }},
}};
/// Those that files of a body have: the last two only where it relaxes.
inline std::span<const MeasureColumn> columns_of(const Measures& m) {
  return std::span(measure_columns).first(measure_columns.size() - (m.relaxes ? 0 : 2));
}

/// What a column was called before: in older files, scripts and scenes.
struct RenamedColumn {
  std::string_view before, now;
};
inline constexpr std::array<RenamedColumn, 4> renamed_columns{{{"gravitational", "external_potential"},
                                                               {"spin_x", "angular_momentum_x"},
                                                               {"spin_y", "angular_momentum_y"},
                                                               {"spin_z", "angular_momentum_z"}}};

/// Measures a state in double precision, whatever the system computes in.
template <class Real>
Measures measure(const SolidSystem<Real>& system, const State<Real>& state);

/// One of the measures alone: exact volume over volume at rest, of cells as far as they are filled.
template <class Real>
double volume_ratio(const std::vector<Level>& levels, const Field<Real>& x);
template <class Real>
double volume_ratio(const Body& body, const Field<Real>& x) {
  return volume_ratio(std::vector<Level>{{body}}, x);
}

}  // namespace mss
