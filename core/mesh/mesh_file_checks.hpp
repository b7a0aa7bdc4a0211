#pragma once

#include <string_view>

namespace mss {

/// Checks before a library reads a file: that it has as many elements as it says, because the library
/// reserves memory for what it says. Throws InputError with a sentence without the name of the file.
void check_stl(std::string_view content);
void check_ply(std::string_view content);

}  // namespace mss
