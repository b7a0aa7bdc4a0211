#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/scene/scene.hpp"

namespace mss {

/// The whole configuration of a scene, defaults filled in and springs calibrated: what summary.json has.
nlohmann::ordered_json to_json(const Scene& scene);

/// The same as a scene file, which load_scene() reads as the same scene if it lies in `folder`. Overrides are
/// in their places; comments are lost.
std::string to_toml(const Scene& scene, const std::filesystem::path& folder);

}  // namespace mss
