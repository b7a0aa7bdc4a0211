#include "experiments/view/recording.hpp"

#include <fmt/format.h>
#include <webp/encode.h>
#include <webp/mux.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/error.hpp"
#include "experiments/io/output.hpp"
#include "experiments/view/image.hpp"

namespace mss::view {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& why) {
  throw std::runtime_error("a frame cannot be made into a WebP: " + why);
}

/// Colours are lossy: a picture of a body in few colours keeps its edges, and takes a tenth of what it is as
/// PNG.
WebPConfig settings() {
  WebPConfig config;
  if (WebPConfigPreset(&config, WEBP_PRESET_DRAWING, 80) == 0) fail("the library has another version");
  return config;
}

class AnimatedWebp final : public Recording {
 public:
  AnimatedWebp(fs::path file, int width, int height, double rate)
      : file_(std::move(file)), width_(width), height_(height), rate_(rate) {
    WebPAnimEncoderOptions options;
    if (WebPAnimEncoderOptionsInit(&options) == 0) fail("the library has another version");
    options.anim_params.loop_count = 0;  // for ever
    encoder_.reset(WebPAnimEncoderNew(width, height, &options));
    if (!encoder_) fail("there is not enough memory");
  }

  void add(const std::vector<std::uint8_t>& pixels) override {
    WebPPicture picture;
    if (WebPPictureInit(&picture) == 0) fail("the library has another version");
    picture.use_argb = 1;
    picture.width = width_;
    picture.height = height_;
    const bool done = WebPPictureImportRGB(&picture, pixels.data(), 3 * width_) != 0 &&
                      WebPAnimEncoderAdd(encoder_.get(), &picture, milliseconds(frames_), &config_) != 0;
    WebPPictureFree(&picture);
    if (!done) fail(WebPAnimEncoderGetError(encoder_.get()));
    ++frames_;
  }

  void finish() override {
    if (frames_ == 0) return;
    WebPAnimEncoderAdd(encoder_.get(), nullptr, milliseconds(frames_),
                       nullptr);  // how long the last one is seen
    WebPData data;
    WebPDataInit(&data);
    if (WebPAnimEncoderAssemble(encoder_.get(), &data) == 0) fail(WebPAnimEncoderGetError(encoder_.get()));
    const std::string bytes(reinterpret_cast<const char*>(data.bytes), data.size);
    WebPDataClear(&data);
    write_atomically(file_, bytes);
  }

 private:
  struct Delete {
    void operator()(WebPAnimEncoder* encoder) const { WebPAnimEncoderDelete(encoder); }
  };

  int milliseconds(long frame) const { return int(std::lround(1000 * double(frame) / rate_)); }

  fs::path file_;
  int width_, height_;
  double rate_;
  WebPConfig config_ = settings();
  std::unique_ptr<WebPAnimEncoder, Delete> encoder_;
  long frames_ = 0;
};

/// Names of files that differ in a number.
struct NumberedName {
  std::string before, after;
  int digits = 4;

  std::string of(long number) const { return fmt::format("{}{:0{}}{}", before, number, digits, after); }
};

/// NAME_0000.png for NAME.png; the number is elsewhere or has other digits where the name says so by %d or
/// %06d. Throws InputError if it has a % otherwise.
NumberedName numbered(const fs::path& file) {
  const std::string name = file.string();
  const std::size_t at = name.find('%');
  if (at == std::string::npos) return {(file.parent_path() / file.stem()).string() + "_", ".png"};
  int digits = 1, read = 0;
  if (name.compare(at, 2, "%d") == 0)
    read = 2;
  else
    std::sscanf(name.c_str() + at, "%%0%1dd%n", &digits, &read);
  if (read == 0 || digits == 0 || name.find('%', at + 1) != std::string::npos)
    throw InputError(
        fmt::format("--record is {}; give the number of a frame one place, as %d or as %04d", name));
  return {name.substr(0, at), name.substr(at + std::size_t(read)), digits};
}

/// One picture a frame.
class PngSeries final : public Recording {
 public:
  PngSeries(NumberedName name, int width, int height)
      : name_(std::move(name)), width_(width), height_(height) {}

  void add(const std::vector<std::uint8_t>& pixels) override {
    write_png(name_.of(frames_++), width_, height_, pixels);
  }
  void finish() override {}

 private:
  NumberedName name_;
  int width_, height_;
  long frames_ = 0;
};

}  // namespace

std::unique_ptr<Recording> make_recording(const fs::path& file, int width, int height, double rate) {
  const bool is_folder = fs::is_directory(file) || !file.has_filename();
  const std::string ending = file.extension().string();
  if (!is_folder && ending != ".webp" && ending != ".png")
    throw InputError(
        fmt::format("--record is {}; give a name that ends in .webp for a moving picture, one that ends in "
                    ".png for a picture a frame, or a directory that ends in /",
                    file.string()));
  const NumberedName frames = is_folder ? NumberedName{(file / "frame_").string(), ".png"} : numbered(file);
  const fs::path folder = is_folder ? file : file.parent_path();
  prepare_directory(folder.empty() ? fs::path(".") : folder);
  if (ending == ".webp" && !is_folder) return std::make_unique<AnimatedWebp>(file, width, height, rate);
  return std::make_unique<PngSeries>(frames, width, height);
}

}  // namespace mss::view
