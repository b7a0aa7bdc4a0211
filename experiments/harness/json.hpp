#pragma once

#include <nlohmann/json.hpp>

namespace mss {

/// JSON whose keys keep the order in which they were added.
using Json = nlohmann::ordered_json;

}  // namespace mss
