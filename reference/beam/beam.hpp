#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/field.hpp"

// The silicone beam of README.md beside this file: what was measured, and what COMSOL makes of it.

namespace mss::reference {

/// A row of measured.csv or comsol.csv.
struct BeamValue {
  std::string run;  ///< "52 g a"; of COMSOL a load alone, "52 g"
  std::string quantity;
  double value = 0;  ///< in the unit that ends the quantity's name
};
const std::vector<BeamValue>& measured_beam();
const std::vector<BeamValue>& comsol_beam();

/// NaN if there is no such row.
double beam_value(const std::vector<BeamValue>& rows, std::string_view run, std::string_view quantity);

/// Observations of two of the runs, as `mss fit` reads them: fit_a.toml.
const char* beam_runs_to_fit_text();

/// A marker on the free end.
struct BeamMarker {
  int number = 0;
  Vec3 point = Vec3::Zero();   ///< of the beam at rest, the nearest one [m]
  Vec3 offset = Vec3::Zero();  ///< from there to the marker's centre [m]
};
const std::vector<BeamMarker>& beam_markers();

/// Turning points of marker 1 in one run about its rest, in time: the first is a lower one.
struct BeamTurn {
  double time = 0;    ///< [s] since the marker had moved beam_start
  double height = 0;  ///< [m]
};
std::vector<BeamTurn> beam_turns(std::string_view run);

/// How far marker 1 has moved when the time of turning points begins [m].
inline constexpr double beam_start = 0.3e-3;

}  // namespace mss::reference
