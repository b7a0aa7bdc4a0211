#pragma once

#include <string>

namespace mss::sundials {

/// As in "6.4.1".
std::string version();

}  // namespace mss::sundials
