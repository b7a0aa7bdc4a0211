// Wavefront OBJ: lines of a keyword and words.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/mesh/polygon_mesh.hpp"
#include "core/mesh/text_scanner.hpp"

namespace mss {

namespace {

/// What has nothing to do with the shape of polygons.
constexpr auto other_keywords = std::to_array<std::string_view>(
    {"vn", "vt", "vp", "p", "l", "o", "g", "s", "mg", "usemtl", "mtllib", "usemap", "maplib", "lod", "bevel",
     "c_interp", "d_interp", "shadow_obj", "trace_obj"});

Vec3 read_vertex(TextScanner& text) {
  Vec3 x;
  for (int a = 0; a < 3; ++a) {
    const std::string_view word = text.word_in_line();
    if (word.empty())
      text.refuse(fmt::format("gives {} of the three coordinates of a vertex; export the mesh again", a));
    x[a] = text.number(word);
  }
  return x;
}

/// A corner such as 3, -1, 3/1, 3//2 or 3/1/2: the vertex, counted from 0.
std::int64_t read_corner(const TextScanner& text, std::string_view word, std::size_t vertices) {
  const std::int64_t index = text.whole_number(word.substr(0, word.find('/')), "a vertex of a face");
  if (index == 0 || index < -std::int64_t(vertices))
    text.refuse(
        fmt::format("has a face with vertex {}, but {} vertices so far; count them from 1, or from -1 "
                    "backwards",
                    index, vertices));
  return index > 0 ? index - 1 : std::int64_t(vertices) + index;
}

void read_face(TextScanner& text, PolygonMesh& mesh) {
  const std::size_t line = text.line();
  for (std::string_view word = text.word_in_line(); !word.empty(); word = text.word_in_line())
    mesh.corners.push_back(read_corner(text, word, mesh.vertices.size()));
  mesh.end_face(line);
}

}  // namespace

PolygonMesh read_obj(std::string_view content) {
  PolygonMesh mesh;
  TextScanner text(content, '#');
  std::size_t unknown = 0;
  std::string first_unknown;
  do {
    const std::string_view keyword = text.word_in_line();
    if (keyword == "v") {
      mesh.vertices.push_back(read_vertex(text));
    } else if (keyword == "f" || keyword == "fo") {
      read_face(text, mesh);
    } else if (!keyword.empty() && std::ranges::find(other_keywords, keyword) == other_keywords.end()) {
      if (unknown++ == 0) first_unknown = fmt::format("line {}, '{}'", text.line(), keyword.substr(0, 40));
    }
  } while (text.next_line());
  if (unknown > 0)
    mesh.remarks.push_back(
        fmt::format("{} of its lines begin with a word that OBJ does not have, and are left "
                    "out; the first is {}",
                    unknown, first_unknown));
  return mesh;
}

}  // namespace mss
