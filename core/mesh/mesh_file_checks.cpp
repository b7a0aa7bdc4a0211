#include "core/mesh/mesh_file_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "core/base/error.hpp"

namespace mss {

namespace {

constexpr std::string_view spaces = " \t\r\n\v\f";

/// Removes the next word from a text and returns it; empty at the end.
std::string_view next_word(std::string_view& text) {
  const std::size_t begin = std::min(text.find_first_not_of(spaces), text.size());
  const std::size_t end = std::min(text.find_first_of(spaces, begin), text.size());
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

std::uint64_t whole_number(std::string_view word, std::string_view of_what) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size())
    throw InputError(
        fmt::format("gives '{}' as the number of {}; export the mesh again", word.substr(0, 40), of_what));
  return value;
}

struct PlyProperty {
  std::size_t size = 0;        ///< of a value, in bytes
  std::size_t count_size = 0;  ///< of the number of values before a list; 0: no list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties{};
};

enum class PlyFormat : std::uint8_t { text, little_endian, big_endian };

std::size_t ply_size(std::string_view type) {
  constexpr std::pair<std::string_view, std::size_t> sizes[]{
      {"char", 1},   {"int8", 1},    {"uchar", 1},  {"uint8", 1},  {"short", 2}, {"int16", 2},
      {"ushort", 2}, {"uint16", 2},  {"int", 4},    {"int32", 4},  {"uint", 4},  {"uint32", 4},
      {"float", 4},  {"float32", 4}, {"double", 8}, {"float64", 8}};
  for (const auto& [name, size] : sizes)
    if (name == type) return size;
  throw InputError(
      fmt::format("has a property of unknown type '{}'; export the mesh again", type.substr(0, 40)));
}

/// What the head of a PLY file says is behind it.
class PlyContent {
 public:
  explicit PlyContent(std::string_view content) : rest_(content) {
    while (true) {
      if (rest_.empty()) throw InputError("ends within its head; export the mesh again");
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      std::string_view line = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      const std::string_view key = next_word(line);
      if (key == "end_header") return;
      read_line(key, line);
    }
  }

  /// Walks over all elements, which must be there.
  void walk() {
    for (const PlyElement& element : elements_) {
      if (element.properties.empty() && element.count > 0)
        throw InputError(
            fmt::format("has elements {} without properties; export the mesh again", element.name));
      for (std::uint64_t i = 0; i < element.count; ++i)
        for (const PlyProperty& property : element.properties) skip(property, element);
    }
  }

 private:
  void read_line(std::string_view key, std::string_view line) {
    if (key == "format") {
      const std::string_view format = next_word(line);
      format_ = format == "ascii"               ? PlyFormat::text
                : format == "binary_big_endian" ? PlyFormat::big_endian
                                                : PlyFormat::little_endian;
    } else if (key == "element") {
      const std::string_view name = next_word(line);
      // assimp would take the digits for the number of elements
      if (name.empty() || !std::isalpha(static_cast<unsigned char>(name.front())))
        throw InputError(
            fmt::format("has an element of the name '{}'; export the mesh again", name.substr(0, 40)));
      // assimp reads strips whose values are of another kind than it expects, beyond its memory
      if (name == "tristrips")
        throw InputError("has strips of triangles, which are not read; export the mesh as triangles");
      elements_.push_back({std::string(name.substr(0, 40)), whole_number(next_word(line), "its elements")});
    } else if (key == "property") {
      if (elements_.empty()) throw InputError("has a property before its elements; export the mesh again");
      const std::string_view type = next_word(line);
      PlyProperty property;
      if (type == "list") {
        property.count_size = ply_size(next_word(line));
        property.size = ply_size(next_word(line));
      } else {
        property.size = ply_size(type);
      }
      elements_.back().properties.push_back(property);
    }
  }

  void skip(const PlyProperty& property, const PlyElement& element) {
    std::uint64_t count = 1;
    if (format_ == PlyFormat::text) {
      if (property.count_size > 0) count = whole_number(word(element), "corners of a polygon");
      for (std::uint64_t i = 0; i < count; ++i) word(element);
    } else {
      if (property.count_size > 0) count = binary(property.count_size, element);
      if (count > rest_.size() / property.size) refuse(element);
      rest_.remove_prefix(count * property.size);
    }
  }

  std::string_view word(const PlyElement& element) {
    const std::string_view word = next_word(rest_);
    if (word.empty()) refuse(element);
    return word;
  }

  std::uint64_t binary(std::size_t size, const PlyElement& element) {
    if (rest_.size() < size) refuse(element);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t at = format_ == PlyFormat::big_endian ? i : size - 1 - i;
      value = value << 8 | static_cast<unsigned char>(rest_[at]);
    }
    rest_.remove_prefix(size);
    return value;
  }

  [[noreturn]] static void refuse(const PlyElement& element) {
    throw InputError(fmt::format(
        "says that it has {} of the element '{}' but ends before; it is cut off or damaged, export it again",
        element.count, element.name));
  }

  std::string_view rest_;
  PlyFormat format_ = PlyFormat::text;
  std::vector<PlyElement> elements_;
};

}  // namespace

void check_stl(std::string_view content) {
  constexpr std::size_t head = 84;
  constexpr std::size_t facet = 50;
  const bool text =
      content.starts_with("solid") && content.substr(0, 1024).find('\0') == std::string_view::npos;
  if (text) return;
  if (content.size() < head)
    throw InputError("is no STL file, it is too short for one; export the mesh again");
  std::uint32_t count = 0;
  for (std::size_t i = 4; i-- > 0;) count = count << 8 | static_cast<unsigned char>(content[80 + i]);
  if (content.size() != head + facet * std::size_t(count))
    throw InputError(
        fmt::format("says that it has {} triangles, but {} fit into its {} bytes; it is cut off or damaged, "
                    "export it again",
                    count, (content.size() - head) / facet, content.size()));
}

void check_ply(std::string_view content) {
  if (!content.starts_with("ply"))
    throw InputError("is no PLY file, it does not begin with 'ply'; give a mesh");
  PlyContent(content).walk();
}

}  // namespace mss
