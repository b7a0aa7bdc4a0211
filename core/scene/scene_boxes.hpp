#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "core/scene/scene.hpp"

namespace mss {

/// Where a body is, for complaints about boxes outside of it.
std::string extent_at_rest(const BodyConfig& config);

/// A box of a scene: that of a table in an array, of the scene or of one of several bodies.
struct PlaceOfBox {
  std::string_view table;
  std::size_t index = 0;
  std::optional<std::size_t> body{};
};
std::string to_string(const PlaceOfBox& place);  ///< "hold.0", "body.1.weight.0"

/// Calls report(place, complaint) for every box without particles, which would silently have no effect.
void find_empty_boxes(
    const Scene& scene,
    const std::function<void(const PlaceOfBox& place, const std::string& complaint)>& report);

}  // namespace mss
