#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace mss::view {

/// Writes a PNG whole or not at all. `pixels`: rows from top to bottom, red, green and blue of each pixel.
/// Throws InputError naming the file if it cannot be written.
void write_png(const std::filesystem::path& file, int width, int height,
               const std::vector<std::uint8_t>& pixels);

}  // namespace mss::view
