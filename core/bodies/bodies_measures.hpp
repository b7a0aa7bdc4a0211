#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/bodies/contact_forces.hpp"
#include "core/springs/solid_system.hpp"

namespace mss {

/// Of one of several bodies at one moment.
struct BodyMeasures {
  Vec3 centre = Vec3::Zero();  ///< of mass [m]
  double kinetic = 0;          ///< [J]
  double volume_ratio = 1;     ///< exact volume of what is filled over that at rest
  double min_jacobian = 1;     ///< as Measures::min_jacobian

  /// See core/base/record.hpp.
  void remember(Record& record);
};

/// Of several bodies, and of contact between or within them.
struct BodiesMeasures {
  std::vector<BodyMeasures> bodies{};      ///< none: there is one body, whose Measures say the same
  std::optional<ContactReport> contact{};  ///< none: it was not asked for

  bool is_finite() const;
  void remember(Record& record);
};

/// Calls visit(name, unit, number) for each number as files name it: body_0_x, ... contact_depth, ...
void for_each_column(const BodiesMeasures& measures,
                     const std::function<void(const std::string&, const char*, double)>& visit);

/// Nothing of a system that is not a BodiesSystem.
template <class Real>
BodiesMeasures measure_bodies(const SolidSystem<Real>& system, const State<Real>& state);

}  // namespace mss
