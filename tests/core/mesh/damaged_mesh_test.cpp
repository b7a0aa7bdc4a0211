// Meshes damaged a thousand times in every format: each ends in a body, or in one sentence that names the
// file.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <chrono>
#include <cmath>
#include <functional>
#include <random>

#include "core/base/error.hpp"
#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/read_mesh.hpp"
#include "core/mesh/shapes.hpp"
#include "tests/core/mesh/mesh_files.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss {
namespace {

class Damager {
 public:
  explicit Damager(unsigned seed) : rng_(seed) {}

  std::size_t below(std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(rng_);
  }

  std::string with_bytes_flipped(std::string text) {
    for (std::size_t n = 1 + below(4); n > 0; --n) text[below(text.size())] ^= char(1 << below(8));
    return text;
  }

  std::string truncated(const std::string& text) { return text.substr(0, below(text.size())); }

  std::string without_a_line(const std::string& text) {
    const std::size_t begin = text.rfind('\n', below(text.size()));
    const std::size_t from = begin == std::string::npos ? 0 : begin + 1;
    const std::size_t end = std::min(text.find('\n', from), text.size() - 1);
    return text.substr(0, from) + text.substr(end + 1);
  }

  /// Of a text a word that begins with a digit, else four bytes.
  std::string with_a_number_replaced(std::string text) {
    static constexpr const char* numbers[]{"0",      "-1",         "1e9",   "nan", "inf",
                                           "1e-320", "4294967296", "1e400", "3.5", "x"};
    const std::size_t from = below(text.size() - 4);
    const bool binary = text.find('\0') != std::string::npos;
    const auto digit = std::find_if(text.begin() + std::ptrdiff_t(from), text.end(),
                                    [](unsigned char c) { return std::isdigit(c) != 0; });
    if (binary && below(4) != 0) {
      static constexpr std::uint32_t values[]{0,          1,          0xffffffff, 0x7fc00000,
                                              0x7f800000, 0x3f800000, 0x80000000};
      return text.replace(from, 4, testing::bytes(values[below(std::size(values))]));
    }
    if (digit == text.end()) return text;
    const auto begin = std::size_t(digit - text.begin());
    const std::size_t end = std::min(text.find_first_of(" \n", begin), text.size());
    return text.replace(begin, end - begin, numbers[below(std::size(numbers))]);
  }

 private:
  std::mt19937 rng_;
};

/// A mesh of one shell: where a shell ends, a file that is cut off looks whole.
TriangleMesh sound_mesh() { return torus(0.7, 0.3, 12, 8); }

struct Sound {
  const char* name;
  std::string content;
};

std::vector<Sound> sound_files() {
  const TriangleMesh mesh = sound_mesh();
  const std::size_t v = mesh.vertices.size(), t = mesh.triangles.size();
  return {{"a.obj", testing::obj(mesh)},
          {"a.stl", testing::text_stl(mesh)},
          {"b.stl", testing::binary_stl(mesh, std::uint32_t(t))},
          {"a.ply", testing::text_ply(mesh, v, t)},
          {"b.ply", testing::binary_ply(mesh, v, t)}};
}

/// What became of a file: the volume of its body [m^3], 0 if it was refused, and whether a word was said.
struct Outcome {
  double volume = 0;
  bool silent = false;
};

Outcome outcome_of(const std::filesystem::path& file) {
  try {
    const MeshOfFile read = read_mesh(file);
    const Box box = bounding_box(read.mesh);
    const Vec3 extent = box.upper - box.lower;
    const double h = extent.maxCoeff() / 12;
    const MeshFill fill =
        fill_meshes({{.mesh = read.mesh, .name = file.string(), .repairs = read.repairs}}, {.cell_size = h});
    const double volume = fill.reports.at(0).filled_volume;
    EXPECT_GT(volume, 0) << file;
    EXPECT_LE(volume, (extent.array() + 2 * h).prod()) << file;
    return {volume, fill.reports[0].notes().empty()};
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.rfind(file.string() + ": ", 0), 0U) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 600U) << message;
    return {};
  }
}

/// Damages every file so often, and expects its volume of bodies of which nothing is said, where `exact`.
void damage_all(int times, bool exact,
                const std::function<std::string(Damager&, const std::string&)>& damage) {
  const testing::SceneFolder folder;
  Damager damager(7);
  for (const auto& [name, content] : sound_files()) {
    const double sound = outcome_of(folder.write(name, content)).volume;
    EXPECT_NEAR(sound, enclosed_volume(sound_mesh()), 0.01) << name;
    for (int i = 0; i < times; ++i) {
      const std::string damaged = damage(damager, content);
      const auto start = std::chrono::steady_clock::now();
      const Outcome outcome = outcome_of(folder.write(name, damaged));
      EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20)) << name << i;
      if (exact && outcome.silent) {
        EXPECT_NEAR(outcome.volume, sound, 0.01 * sound) << name << " " << i;
      }
    }
  }
}

TEST(DamagedMesh, OfWhichBytesAreFlipped) {
  damage_all(250, false, [](Damager& d, const std::string& text) { return d.with_bytes_flipped(text); });
}

TEST(DamagedMesh, ThatIsCutOffIsRefusedOrRemarkedOnOrTheSame) {
  damage_all(250, true, [](Damager& d, const std::string& text) { return d.truncated(text); });
}

TEST(DamagedMesh, WithoutALineIsRefusedOrRemarkedOnOrTheSame) {
  damage_all(250, true, [](Damager& d, const std::string& text) { return d.without_a_line(text); });
}

TEST(DamagedMesh, OfWhichANumberIsReplaced) {
  damage_all(250, false, [](Damager& d, const std::string& text) { return d.with_a_number_replaced(text); });
}

}  // namespace
}  // namespace mss
