#pragma once

#include <string>

#include "reference/materials.hpp"

// What `mss material --like` prints of published materials.

namespace mss::cli {

/// The material of a name, whatever its case, with blanks or hyphens for underscores. Throws InputError that
/// names those that contain it, or the nearest one.
const reference::PublishedMaterial& find_published_material(const std::string& name);

/// All of them, a line each.
std::string published_material_list();

/// Constants, how they were measured, source, and material_block().
std::string published_material_card(const reference::PublishedMaterial& material);

/// Tables [material] and, where the loss is known, [damping] of a scene file.
std::string material_block(const reference::PublishedMaterial& material);

/// Closer to 1/2 the volume force stiffens, and steps shorten, for less than a percent of difference.
inline constexpr double largest_block_poisson = 0.495;

}  // namespace mss::cli
