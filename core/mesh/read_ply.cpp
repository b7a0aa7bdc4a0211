// PLY: a head that says what is behind it, and that as text or binary.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <utility>

#include "core/base/error.hpp"
#include "core/mesh/polygon_mesh.hpp"
#include "core/mesh/text_scanner.hpp"

namespace mss {

namespace {

enum class PlyFormat : std::uint8_t { text, little_endian, big_endian };

struct PlyType {
  enum class Kind : std::uint8_t { none, whole, not_negative, real };
  Kind kind = Kind::none;
  std::size_t size = 0;  ///< in bytes
};

struct PlyProperty {
  std::string name;
  PlyType type;
  PlyType count_type;  ///< of the number of values before a list; none: no list
  bool is_list() const { return count_type.kind != PlyType::Kind::none; }
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties{};
};

PlyType ply_type(const TextScanner& text, std::string_view name) {
  using enum PlyType::Kind;
  static constexpr std::pair<std::string_view, PlyType> types[]{
      {"char", {whole, 1}},          {"int8", {whole, 1}},          {"uchar", {not_negative, 1}},
      {"uint8", {not_negative, 1}},  {"short", {whole, 2}},         {"int16", {whole, 2}},
      {"ushort", {not_negative, 2}}, {"uint16", {not_negative, 2}}, {"int", {whole, 4}},
      {"int32", {whole, 4}},         {"uint", {not_negative, 4}},   {"uint32", {not_negative, 4}},
      {"float", {real, 4}},          {"float32", {real, 4}},        {"double", {real, 8}},
      {"float64", {real, 8}}};
  for (const auto& [known, type] : types)
    if (known == name) return type;
  text.refuse(fmt::format("has a property of unknown type '{}'; export the mesh again", name.substr(0, 40)));
}

class PlyReader {
 public:
  explicit PlyReader(std::string_view content) : content_(content), text_(content) {
    text_.word();  // ply
    // what ends the first line ends the last one too: binary data may begin with a byte of LF
    const std::size_t end = std::min(content.find_first_of("\r\n"), content.size());
    line_end_ = content.substr(end, content.substr(end).starts_with("\r\n") ? 2 : 1);
    while (text_.next_line()) {
      const std::string_view key = text_.word_in_line();
      if (key == "end_header") {
        begin_data();
        return;
      }
      read_line(key);
    }
    throw InputError("ends within its head; export the mesh again");
  }

  PolygonMesh read() {
    for (const PlyElement& element : elements_) {
      if (element.properties.empty() && element.count > 0)
        throw InputError(
            fmt::format("has elements {} without properties; export the mesh again", element.name));
      if (element.name == "vertex")
        read_vertices(element);
      else if (element.name == "face")
        read_faces(element);
      else
        for (std::int64_t i = 0; i < element.count; ++i) {
          for (const PlyProperty& property : element.properties) read_values(property, element);
          end_line();
        }
    }
    remark_rest();
    return std::move(mesh_);
  }

 private:
  void read_line(std::string_view key) {
    if (key == "format") {
      format_ = read_format(text_.word_in_line());
    } else if (key == "element") {
      const std::string_view name = text_.word_in_line();
      if (name == "tristrips")
        throw InputError("has strips of triangles, which are not read; export the mesh as triangles");
      const std::int64_t count = text_.whole_number(text_.word_in_line(), "the number of its elements");
      if (count < 0)
        text_.refuse(fmt::format("gives {} as the number of its elements; give 0 or more", count));
      elements_.push_back({std::string(name.substr(0, 40)), count});
    } else if (key == "property") {
      if (elements_.empty()) throw InputError("has a property before its elements; export the mesh again");
      elements_.back().properties.push_back(read_property());
    }
  }

  PlyFormat read_format(std::string_view name) const {
    if (name == "ascii") return PlyFormat::text;
    if (name == "binary_little_endian") return PlyFormat::little_endian;
    if (name == "binary_big_endian") return PlyFormat::big_endian;
    text_.refuse(
        fmt::format("gives '{}' as the format; it is ascii, binary_little_endian or binary_big_endian",
                    name.substr(0, 40)));
  }

  PlyProperty read_property() {
    PlyProperty property;
    std::string_view type = text_.word_in_line();
    if (type == "list") {
      property.count_type = ply_type(text_, text_.word_in_line());
      if (property.count_type.kind == PlyType::Kind::real)
        text_.refuse("counts the values of a list in a type with a point; export the mesh again");
      type = text_.word_in_line();
    }
    property.type = ply_type(text_, type);
    property.name = text_.word_in_line();
    return property;
  }

  void begin_data() {
    at_ = std::min(content_.find(line_end_, text_.position()), content_.size() - line_end_.size()) +
          line_end_.size();
    text_.next_line();
  }

  /// Where the property of a name is; the last of them if there are several.
  static std::size_t find(const PlyElement& element, std::string_view name, bool is_list) {
    for (std::size_t p = element.properties.size(); p-- > 0;)
      if (element.properties[p].name == name && element.properties[p].is_list() == is_list) return p;
    return element.properties.size();
  }

  void read_vertices(const PlyElement& element) {
    std::vector<int> axis_of(element.properties.size() + 1, -1);
    for (int a = 0; a < 3; ++a)
      axis_of[find(element, std::string_view("xyz").substr(std::size_t(a), 1), false)] = a;
    if (element.count > 0 && axis_of.back() >= 0)
      throw InputError("has vertices without x, y and z; export the mesh again");
    for (std::int64_t i = 0; i < element.count; ++i) {
      Vec3 x = Vec3::Zero();
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        read_values(element.properties[p], element);
        if (axis_of[p] >= 0) x[axis_of[p]] = values_.front();
      }
      mesh_.vertices.push_back(x);
      end_line();
    }
  }

  void read_faces(const PlyElement& element) {
    const std::size_t corners =
        std::min(find(element, "vertex_indices", true), find(element, "vertex_index", true));
    if (element.count > 0 && corners == element.properties.size())
      throw InputError("has faces without a list vertex_indices; export the mesh again");
    for (std::int64_t i = 0; i < element.count; ++i) {
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        read_values(element.properties[p], element);
        if (p == corners)
          for (const double value : values_) mesh_.corners.push_back(vertex(value));
      }
      mesh_.end_face();
      end_line();
    }
  }

  /// Every element of a text has a line.
  void end_line() {
    if (format_ != PlyFormat::text || text_.word_in_line().empty()) return;
    if (long_lines_++ == 0) first_long_line_ = text_.line();
    while (!text_.word_in_line().empty()) {
    }
  }

  static std::int64_t vertex(double value) {
    if (!(std::abs(value) < 1e15) || value != std::floor(value))
      throw InputError(fmt::format("has a face with vertex {}; give whole numbers", value));
    return std::int64_t(value);
  }

  /// Reads what one element has of a property.
  void read_values(const PlyProperty& property, const PlyElement& element) {
    double count = 1;
    if (property.is_list()) count = value(property.count_type, element);
    if (!(count >= 0) || count != std::floor(count))
      throw InputError(fmt::format("has a list of {} values in the element '{}'; export the mesh again",
                                   count, element.name));
    const double left = double(content_.size() - (format_ == PlyFormat::text ? text_.position() : at_));
    if (count > left) refuse(element);
    values_.clear();
    for (std::size_t i = 0; i < std::size_t(count); ++i) values_.push_back(value(property.type, element));
  }

  double value(const PlyType& type, const PlyElement& element) {
    if (format_ == PlyFormat::text) {
      const std::string_view word = text_.word();
      if (word.empty()) refuse(element);
      return text_.number(word);
    }
    if (content_.size() - at_ < type.size) refuse(element);
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < type.size; ++i) {
      const std::size_t from = format_ == PlyFormat::big_endian ? i : type.size - 1 - i;
      bits = bits << 8 | static_cast<unsigned char>(content_[at_ + from]);
    }
    at_ += type.size;
    return number_of(bits, type);
  }

  static double number_of(std::uint64_t bits, const PlyType& type) {
    if (type.kind == PlyType::Kind::not_negative) return double(bits);
    if (type.kind == PlyType::Kind::real)
      return type.size == 4 ? double(std::bit_cast<float>(std::uint32_t(bits))) : std::bit_cast<double>(bits);
    const std::size_t unused = 64 - 8 * type.size;
    return double(std::int64_t(bits << unused) >> unused);
  }

  void remark_rest() {
    if (long_lines_ > 0)
      mesh_.remarks.push_back(fmt::format(
          "{} of its lines have more values than the head says, which are left out; the first is line {}",
          long_lines_, first_long_line_));
    const bool more = format_ == PlyFormat::text ? !text_.word().empty() : at_ < content_.size();
    if (more)
      mesh_.remarks.emplace_back("the file goes on behind its last element, and the rest is left out");
  }

  [[noreturn]] static void refuse(const PlyElement& element) {
    throw InputError(fmt::format(
        "says that it has {} of the element '{}' but ends before; it is cut off or damaged, export it again",
        element.count, element.name));
  }

  std::string_view content_;
  TextScanner text_;
  std::string_view line_end_;
  std::size_t at_ = 0;  ///< in binary data
  PlyFormat format_ = PlyFormat::text;
  std::vector<PlyElement> elements_;
  std::vector<double> values_;
  std::size_t long_lines_ = 0;  ///< with values behind their element
  std::size_t first_long_line_ = 0;
  PolygonMesh mesh_;
};

}  // namespace

PolygonMesh read_ply(std::string_view content) {
  if (TextScanner(content).word() != "ply")
    throw InputError("is no PLY file, it does not begin with 'ply'; give a mesh");
  return PlyReader(content).read();
}

}  // namespace mss
