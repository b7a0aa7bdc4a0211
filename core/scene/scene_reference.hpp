#pragma once

#include <string>
#include <utility>
#include <vector>

namespace mss {

/// All keys of a scene file with what they mean and may be, as Markdown: core/scene/README.md contains it.
std::string scene_reference();

/// The same as lines of (key with its table, text).
std::vector<std::pair<std::string, std::string>> scene_key_lines();

}  // namespace mss
