#pragma once

#include "core/scene/toml_reader.hpp"

namespace mss {

/// All keys of a scene file. Any other key is an error that suggests the nearest of these.
const KnownKeys& scene_keys();

/// Names that keys had before.
const KnownKeys& old_scene_keys();

}  // namespace mss
