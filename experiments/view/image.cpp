#include "experiments/view/image.hpp"

#include <png.h>

#include <stdexcept>
#include <string>

#include "experiments/io/output.hpp"

namespace mss::view {

void write_png(const std::filesystem::path& file, int width, int height,
               const std::vector<std::uint8_t>& pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = png_uint_32(width);
  image.height = png_uint_32(height);
  image.format = PNG_FORMAT_RGB;
  const auto encode = [&](void* memory, png_alloc_size_t& size) {
    if (png_image_write_to_memory(&image, memory, &size, 0, pixels.data(), 0, nullptr) == 0)
      throw std::runtime_error("a picture cannot be made into a PNG: " + std::string(image.message));
  };
  png_alloc_size_t size = 0;
  encode(nullptr, size);
  std::string bytes(size, '\0');
  encode(bytes.data(), size);
  bytes.resize(size);
  write_atomically(file, bytes);
}

}  // namespace mss::view
