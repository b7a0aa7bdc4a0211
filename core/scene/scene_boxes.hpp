#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "core/scene/scene.hpp"

namespace mss {

/// Where a body is, for complaints about boxes outside of it.
std::string extent_at_rest(const BodyConfig& config);

/// Calls report(table, index, complaint) for every box without particles, which would silently have no
/// effect.
void find_empty_boxes(const Scene& scene, const std::function<void(std::string_view table, std::size_t index,
                                                                   const std::string& complaint)>& report);

}  // namespace mss
