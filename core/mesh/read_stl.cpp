// STL: triangles with three places each, as text or binary.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>

#include "core/base/error.hpp"
#include "core/mesh/polygon_mesh.hpp"
#include "core/mesh/text_scanner.hpp"

namespace mss {

namespace {

constexpr std::size_t head = 84;   ///< bytes before the triangles, the last four their number
constexpr std::size_t facet = 50;  ///< bytes of a triangle: normal, three places, two bytes more

std::uint32_t number_at(std::string_view content, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(content[at + i]);
  return value;
}

std::string lower(std::string_view word) {
  std::string text(word);
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

/// Binary files may begin with "solid" too, but their number of triangles has a zero byte.
bool is_text(std::string_view content) {
  if (content.size() >= head && content.size() == head + facet * std::size_t(number_at(content, 80)))
    return false;
  if (content.substr(0, head).find('\0') != std::string_view::npos) return false;
  return lower(TextScanner(content).word()).starts_with("solid");
}

PolygonMesh read_binary(std::string_view content) {
  if (content.size() < head)
    throw InputError("is no STL file, it is too short for one; export the mesh again");
  const std::uint32_t count = number_at(content, 80);
  const std::size_t fitting = (content.size() - head) / facet;
  if (count > fitting || (count == 0 && fitting > 0))
    throw InputError(
        fmt::format("says that it has {} triangles, but {} fit into its {} bytes; it is cut off or damaged, "
                    "export it again",
                    count, fitting, content.size()));
  PolygonMesh mesh;
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      Vec3 x;
      for (std::size_t a = 0; a < 3; ++a)
        x[Eigen::Index(a)] =
            double(std::bit_cast<float>(number_at(content, head + facet * t + 12 + 12 * c + 4 * a)));
      mesh.corners.push_back(std::int64_t(mesh.vertices.size()));
      mesh.vertices.push_back(x);
    }
    mesh.end_face();
  }
  if (const std::size_t behind = content.size() - head - facet * count; behind > 0)
    mesh.remarks.push_back(fmt::format("the file has {} byte{} behind its {} triangles, which {} left out",
                                       behind, behind == 1 ? "" : "s", count, behind == 1 ? "is" : "are"));
  return mesh;
}

/// Reads words that have a meaning and passes over all others, such as normals.
class TextStl {
 public:
  explicit TextStl(std::string_view content) : text_(content) {}

  PolygonMesh read() {
    for (std::string_view word = text_.word(); !word.empty(); word = text_.word()) obey(lower(word));
    if (corners_ > 0) refuse_end();
    if (!ended_) mesh_.remarks.emplace_back("the file ends without 'endsolid', and may be cut off");
    return std::move(mesh_);
  }

 private:
  void obey(const std::string& word) {
    if (word == "solid" || word == "endsolid") {
      expect_no_facet(word);
      while (!text_.word_in_line().empty()) {  // the name
      }
      ended_ = word == "endsolid";
    } else if (word == "facet" || word == "outer") {
      expect_no_facet(word);
    } else if (word == "vertex") {
      add_corner();
    } else if (word == "endloop") {
      if (corners_ < 3)
        text_.refuse(fmt::format("a facet of {} vertices; it is damaged, export the mesh again", corners_));
      mesh_.end_face(text_.line());
      corners_ = 0;
    }
  }

  [[noreturn]] void refuse_end() const {
    text_.refuse("the file ends within a facet; it is cut off, export it again");
  }

  void expect_no_facet(const std::string& word) const {
    if (corners_ > 0)
      text_.refuse(fmt::format("'{}' within a facet; the file is damaged, export the mesh again", word));
  }

  void add_corner() {
    Vec3 x;
    for (int a = 0; a < 3; ++a) {
      const std::string_view word = text_.word();
      if (word.empty()) refuse_end();
      x[a] = text_.number(word);
    }
    mesh_.corners.push_back(std::int64_t(mesh_.vertices.size()));
    mesh_.vertices.push_back(x);
    ++corners_;
  }

  TextScanner text_;
  PolygonMesh mesh_;
  std::size_t corners_ = 0;  ///< of the facet that is read
  bool ended_ = false;
};

}  // namespace

PolygonMesh read_stl(std::string_view content) {
  return is_text(content) ? TextStl(content).read() : read_binary(content);
}

}  // namespace mss
