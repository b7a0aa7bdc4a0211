#pragma once

#include <string>
#include <vector>

namespace mss::reference {

/// A row of materials.csv: constants of a soft material as published.
struct PublishedMaterial {
  std::string name;
  std::string kind;                                 ///< rubber, foam, gel or tissue
  double young = 0, young_low = 0, young_high = 0;  ///< [Pa] to begin with, and where papers differ
  double poisson = 0;
  bool poisson_measured = false;  ///< false: assumed, as the source does, since it keeps its volume
  double density = 0;             ///< [kg/m^3]
  double loss = 0;                ///< tangent of the loss angle, twice the damping ratio; NaN: not published
  double loss_frequency = 0;      ///< [Hz] at which that is; NaN as well
  std::string measured;           ///< how, and of what
  std::string source;

  double shear_modulus() const { return young / (2 * (1 + poisson)); }  ///< [Pa]
  /// Of shear, of the Kelvin-Voigt solid that has this loss at this frequency [Pa s]; NaN: not published.
  double viscosity() const;
};

/// All of them, in the order of the table. Throws std::invalid_argument naming the line of a row that is not
/// one.
const std::vector<PublishedMaterial>& published_materials();

/// The same from text as in materials.csv.
std::vector<PublishedMaterial> read_materials(const std::string& csv);

}  // namespace mss::reference
