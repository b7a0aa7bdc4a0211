#pragma once

#include <fmt/format.h>

#include <string>

#include "core/base/field.hpp"

namespace mss::studies::contact {

/// A vector as scene files have it.
inline std::string scene_text(const Vec3& x) { return fmt::format("[{}, {}, {}]", x[0], x[1], x[2]); }

}  // namespace mss::studies::contact
