#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace mss::fit {

/// A number of a scene that is fitted.
struct Parameter {
  std::string key;   ///< as `--set` takes it
  double start = 0;  ///< the scene's value
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();

  /// Positive ones are fitted in the logarithm.
  bool is_logarithmic() const { return start > 0 && !(low <= 0 && std::isfinite(low)); }
  /// The coordinate that is fitted, and back.
  double coordinate(double value) const;
  double value(double coordinate) const;
  /// The same beyond the bounds too.
  double unbounded(double coordinate) const;
  /// The override that gives a scene this value.
  std::string setting(double value) const;
};

/// From "KEY" or "KEY=LOW..HIGH", of which a bound may be left out. Throws InputError for what is no number
/// of the scene, and for a start that lies outside the bounds or has no logarithm.
Parameter read_parameter(const std::string& text, const Scene& scene);

/// The same of several, each once.
std::vector<Parameter> read_parameters(const std::vector<std::string>& texts, const Scene& scene);

}  // namespace mss::fit
