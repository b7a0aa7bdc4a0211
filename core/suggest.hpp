#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace mss {

/// The known name that is fewest edits (insert, delete, replace) away from `found`; empty if none are known.
std::string nearest(std::string_view found, const std::vector<std::string>& known);

}  // namespace mss
