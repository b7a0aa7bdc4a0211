#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace mss::view {

/// A moving picture that grows by a frame at a time.
class Recording {
 public:
  Recording() = default;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  virtual ~Recording() = default;

  /// Pixels as write_png() takes them.
  virtual void add(const std::vector<std::uint8_t>& pixels) = 0;
  /// Makes a file of the frames added so far, unless each has its own. Throws InputError naming the file if
  /// it cannot be written.
  virtual void finish() = 0;
};

/// By the name of the file: NAME.webp is an animated WebP that plays for ever at `rate` frames a second,
/// in which a frame that equals the one before is no frame but lasts longer;
/// NAME.png stands for NAME_0000.png and so on, a picture a frame, or says by %d or %06d where the number
/// belongs; a directory, or what ends in /, gets frame_0000.png and so on. Throws InputError if the name is
/// another or cannot be written to.
std::unique_ptr<Recording> make_recording(const std::filesystem::path& file, int width, int height,
                                          double rate);

}  // namespace mss::view
