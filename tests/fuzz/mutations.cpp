#include "tests/fuzz/mutations.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <set>
#include <string_view>
#include <vector>

#include "tests/fuzz/scene_words.hpp"

namespace mss::fuzz {

namespace {

/// Longest that an input may become.
constexpr std::size_t most_bytes = 1 << 16;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::string joined_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

struct Span {
  std::size_t begin, size;
};

/// Where the numbers of a text are.
std::vector<Span> numbers_in(const std::string& text) {
  const auto is_part = [&](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '+';
  };
  std::vector<Span> spans;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!is_part(text[i]) || (i > 0 && std::isalnum(static_cast<unsigned char>(text[i - 1])) != 0)) continue;
    std::size_t end = i;
    while (end < text.size() && (is_part(text[end]) || text[end] == 'e')) ++end;
    spans.push_back({i, end - i});
    i = end;
  }
  return spans;
}

void replace_number(std::string& text, std::string_view number, Random& random) {
  const std::vector<Span> spans = numbers_in(text);
  if (spans.empty()) return;
  const Span span = random.pick(spans);
  text.replace(span.begin, span.size, number);
}

std::string some_number(Random& random) {
  if (random.once_in(2)) return std::string(random.pick(extreme_numbers));
  return std::to_string(random.below(12)) +
         (random.once_in(2) ? "." + std::to_string(random.below(100)) : "");
}

std::string piece_of(const std::string& text, Random& random) {
  const std::size_t begin = random.below(text.size());
  return text.substr(begin, 1 + random.below(64));
}

/// Deep brackets, long words, characters that terminals obey.
std::string odd_text(Random& random) {
  const std::size_t times = std::size_t{1} << random.below(14);
  const auto repeated = [&](std::string_view word) {
    std::string text;
    for (std::size_t i = 0; i < times; ++i) text += word;
    return text;
  };
  switch (random.below(9)) {
    case 0:
      return repeated("[");
    case 1:
      return repeated("{a=");
    case 2:
      return "x" + repeated(".a") + " = 1\n";
    case 3:
      return repeated("A");
    case 4:
      return repeated("9");
    case 5:
      return "\x1b[2J\x07\x7f";
    case 6:
      return "\xff\xfe\xc3\x28\xed\xa0\x80";
    case 7:
      return std::string(1 + random.below(4), '\0');
    default:
      return "\xef\xbb\xbf";
  }
}

void swap_lines(std::vector<std::string>& lines, Random& random) {
  std::swap(lines[random.below(lines.size())], lines[random.below(lines.size())]);
}

using Place = std::vector<std::string>::iterator;
Place some_place(std::vector<std::string>& lines, Random& random) {
  return lines.begin() + std::ptrdiff_t(random.below(lines.size()));
}

/// Inserts a few neighbouring lines of one text in another.
void splice_lines(std::vector<std::string>& lines, const std::string& other, Random& random) {
  const std::vector<std::string> others = lines_of(other);
  if (others.empty()) return;
  const std::size_t first = random.below(others.size());
  const std::size_t count = std::min(1 + random.below(8), others.size() - first);
  lines.insert(some_place(lines, random), others.begin() + std::ptrdiff_t(first),
               others.begin() + std::ptrdiff_t(first + count));
}

std::string header_of(std::string_view table) { return "[" + std::string(table) + "]"; }

/// The line where a table begins, the last of those of an array; appended if it is not there.
std::size_t find_table_line(std::vector<std::string>& lines, const std::string& header) {
  for (std::size_t i = lines.size(); i-- > 0;)
    if (lines[i].starts_with(header)) return i;
  lines.push_back(header);
  return lines.size() - 1;
}

/// Gives a table a key, in place of the one it has or beside it.
void set_word(std::vector<std::string>& lines, const SceneWord& word, bool replaces) {
  const std::size_t header = find_table_line(lines, header_of(word.table));
  const std::string line = std::string(word.key) + " = " + std::string(word.value);
  for (std::size_t i = header + 1; replaces && i < lines.size() && !lines[i].starts_with("["); ++i)
    if (lines[i].starts_with(std::string(word.key) + " ")) {
      lines[i] = line;
      return;
    }
  lines.insert(lines.begin() + std::ptrdiff_t(header) + 1, line);
}

void replace_value(std::string& line, std::string_view value) {
  if (const std::size_t equals = line.find('='); equals != std::string::npos)
    line = line.substr(0, equals + 1) + " " + std::string(value);
}

void damage_key(std::string& line, Random& random) {
  const std::size_t end = line.find_first_of(" =]");
  if (end == std::string::npos || end == 0) return;
  line[random.below(end)] = char('a' + random.below(26));
}

void repeat(std::vector<std::string>& lines, Random& random) {
  const std::size_t first = random.below(lines.size());
  const std::vector<std::string> some(
      lines.begin() + std::ptrdiff_t(first),
      lines.begin() + std::ptrdiff_t(std::min(first + 1 + random.below(6), lines.size())));
  for (std::size_t times = 1 + random.below(20); times > 0; --times)
    lines.insert(lines.begin() + std::ptrdiff_t(first), some.begin(), some.end());
}

/// A number of four bytes in a binary file: a count, an index, a coordinate.
void replace_binary_number(std::string& bytes, Random& random) {
  constexpr auto numbers =
      std::to_array<std::uint32_t>({0, 1, 3, 255, 65536, 0x7fffffff, 0x80000000, 0xffffffff, 0x7f800000,
                                    0x7fc00000, 0xff7fffff, 0x00000001, 0x3f800000});
  if (bytes.size() < 4) return;
  auto raw = std::bit_cast<std::array<char, 4>>(random.pick(numbers));
  if (random.once_in(4)) std::reverse(raw.begin(), raw.end());
  const std::size_t at = random.once_in(4) && bytes.size() > 84 ? 80 : random.below(bytes.size() - 3);
  bytes.replace(at, 4, raw.data(), 4);
}

void damage_obj(std::string& text, Random& random) {
  constexpr auto words = std::to_array<std::string_view>({"f 1 2 3 4 5 6",
                                                          "f 1//2 2//3 3//1",
                                                          "f -1 -2 -3",
                                                          "f 0 0 0",
                                                          "f 1 2",
                                                          "f 1",
                                                          "f",
                                                          "l 1 2 3",
                                                          "p 1",
                                                          "v",
                                                          "v 1",
                                                          "v 1 2",
                                                          "v 1 2 3 4",
                                                          "v 1 2 3 0",
                                                          "v 1 2 3 1 1 1",
                                                          "v nan 0 0",
                                                          "v inf 0 0",
                                                          "v 1e39 0 0",
                                                          "vn 0 0",
                                                          "vt 1",
                                                          "o",
                                                          "o a",
                                                          "g",
                                                          "g a b",
                                                          "usemtl x",
                                                          "usemtl",
                                                          "mtllib x.mtl",
                                                          "mtllib ../../x",
                                                          "s 1",
                                                          "s off",
                                                          "vp 1",
                                                          "curv 0 1 1",
                                                          "call x.obj",
                                                          "f 1/2/3/4 2 3",
                                                          "f 1/ 2/ 3/",
                                                          "f 2147483648 1 2",
                                                          "f -2147483648 1 2",
                                                          "f 99999999999999999999 1 2",
                                                          "f 1 2 3 \\",
                                                          "\\",
                                                          "mg 1",
                                                          "#",
                                                          "f 1 1 1",
                                                          "f 1 2 3 1 2 3",
                                                          "f a b c",
                                                          "F 1 2 3",
                                                          "v 1,5 2 3"});
  std::vector<std::string> lines = lines_of(text);
  if (lines.empty()) return;
  lines.insert(some_place(lines, random), std::string(random.pick(words)));
  text = joined_lines(lines);
}

void damage_ply(std::string& text, Random& random) {
  constexpr auto words = std::to_array<std::string_view>({"element vertex 4294967295",
                                                          "element face 18446744073709551615",
                                                          "element vertex 0",
                                                          "element vertex -1",
                                                          "element face 1",
                                                          "element edge 3",
                                                          "element",
                                                          "element x",
                                                          "property",
                                                          "property float",
                                                          "property float w",
                                                          "property double x",
                                                          "property list uchar int vertex_index",
                                                          "property list int int vertex_indices",
                                                          "property list float float vertex_indices",
                                                          "property list uchar double vertex_indices",
                                                          "property list",
                                                          "property uchar red",
                                                          "property int8 x",
                                                          "comment",
                                                          "obj_info x",
                                                          "end_header",
                                                          "format ascii 1.0",
                                                          "format binary_little_endian 1.0",
                                                          "format binary_big_endian 1.0",
                                                          "format x",
                                                          "property list uchar uchar tristrips",
                                                          "element tristrips 1",
                                                          "property list int int vertex_indices",
                                                          "element material 1",
                                                          "property float s",
                                                          "property float nx"});
  const std::size_t end = std::min(text.find("end_header"), text.size());
  std::vector<std::string> head = lines_of(text.substr(0, end));
  if (head.empty()) return;
  if (random.once_in(2))
    head.insert(some_place(head, random), std::string(random.pick(words)));
  else
    *some_place(head, random) = std::string(random.pick(words));
  text = joined_lines(head) + text.substr(end);
}

void damage_stl(std::string& text, Random& random) {
  constexpr auto words = std::to_array<std::string_view>(
      {"solid", "solid x", "endsolid", "facet", "facet normal", "facet normal nan nan nan", "outer loop",
       "endloop", "endfacet", "vertex", "vertex 1", "vertex 1 2", "vertex 1 2 3", "vertex 1e39 0 0",
       "vertex nan nan nan", "vertex a b c", "solid solid", "color 1 2 3", "vertex 1,5 2 3"});
  std::vector<std::string> lines = lines_of(text);
  if (lines.empty()) return;
  lines.insert(some_place(lines, random), std::string(random.pick(words)));
  text = joined_lines(lines);
}

}  // namespace

void damage_bytes(std::string& text, const std::string& other, Random& random) {
  const std::size_t at = random.below(text.size());
  switch (random.below(8)) {
    case 0:
      if (!text.empty()) text[at] = char(text[at] ^ (1 << random.below(8)));
      break;
    case 1:
      if (!text.empty()) text[at] = char(random.below(256));
      break;
    case 2:
      text.insert(at, 1, char(random.below(256)));
      break;
    case 3:
      text.erase(at, 1 + random.below(16));
      break;
    case 4:
      text.insert(at, piece_of(text, random));
      break;
    case 5:
      text.insert(at, piece_of(other, random));
      break;
    case 6:
      text.insert(at, odd_text(random));
      break;
    default:
      text.resize(at);
  }
  if (text.size() > most_bytes) text.resize(most_bytes);
}

void damage_lines(std::string& text, const std::string& other, Random& random) {
  const std::size_t what = random.below(12);
  if (what < 7) return replace_number(text, some_number(random), random);
  std::vector<std::string> lines = lines_of(text);
  if (lines.empty()) return;
  switch (what) {
    case 7:
      lines.insert(some_place(lines, random), std::string(random.pick(lines)));
      break;
    case 8:
      lines.erase(some_place(lines, random));
      break;
    case 9:
      swap_lines(lines, random);
      break;
    case 10:
      splice_lines(lines, other, random);
      break;
    default:
      repeat(lines, random);
  }
  text = joined_lines(lines);
  if (text.size() > most_bytes) text.resize(most_bytes);
}

void damage_scene(std::string& text, const std::string& other, Random& random) {
  if (random.once_in(12)) return damage_bytes(text, other, random);
  if (random.once_in(3)) return damage_lines(text, other, random);
  std::vector<std::string> lines = lines_of(text);
  if (lines.empty()) return;
  std::string& line = lines[random.below(lines.size())];
  switch (random.below(12)) {
    case 0:
      replace_value(line, random.pick(extreme_numbers));
      break;
    case 1:
      replace_value(line, random.pick(other_values));
      break;
    case 2:
      replace_value(line, random.pick(scene_words).value);
      break;
    case 3:
      damage_key(line, random);
      break;
    case 4:
      set_word(lines, random.pick(scene_words), false);
      break;
    case 5:
      lines.push_back(header_of(random.pick(scene_words).table));
      lines.push_back(std::string(random.pick(scene_words).key) + " = " + some_number(random));
      break;
    default:
      set_word(lines, random.pick(scene_words), true);
  }
  text = joined_lines(lines);
}

void damage_voxels(std::string& text, const std::string& other, Random& random) {
  constexpr std::string_view cells = "##..A19BZ \t\r0a";
  if (random.once_in(6)) return damage_bytes(text, other, random);
  if (random.once_in(3)) return damage_lines(text, other, random);
  for (std::size_t times = 1 + random.below(4); times > 0 && !text.empty(); --times) {
    char& cell = text[random.below(text.size())];
    if (cell != '\n' || random.once_in(8)) cell = random.pick(cells);
  }
}

void damage_mesh(Kind kind, std::string& text, const std::string& other, Random& random) {
  if (random.once_in(5)) return damage_bytes(text, other, random);
  const bool binary = text.find('\0') != std::string::npos;
  if (binary && !random.once_in(4)) return replace_binary_number(text, random);
  if (!binary && random.once_in(2)) return damage_lines(text, other, random);
  if (kind == Kind::obj) return damage_obj(text, random);
  if (kind == Kind::ply) return damage_ply(text, random);
  if (!binary) return damage_stl(text, random);
}

void drop_repeated_keys(std::string& text) {
  std::string kept, table;
  std::set<std::string> seen;
  bool drops = false;
  std::size_t arrays = 0;
  for (const std::string& line : lines_of(text)) {
    if (line.starts_with("[")) {
      table = line.substr(0, line.find(']'));
      if (line.starts_with("[[")) table += std::to_string(++arrays);
      drops = !seen.insert(table).second;
    }
    const std::string key = line.substr(0, line.find_first_of(" ="));
    const bool has_key = !line.empty() && std::isalpha(static_cast<unsigned char>(line[0])) != 0;
    if (drops || (has_key && !seen.insert(std::string(table).append("/").append(key)).second)) continue;
    kept.append(line).append("\n");
  }
  text = kept;
}

std::string random_override(Random& random) {
  const SceneWord& word = random.pick(scene_words);
  std::string table(word.table);
  if (table.starts_with("["))
    table = table.substr(1, table.size() - 2) + "." + std::to_string(random.below(3));
  std::string setting = table + "." + std::string(word.key) + "=";
  switch (random.below(5)) {
    case 0:
      setting += random.pick(extreme_numbers);
      break;
    case 1:
      setting += random.pick(other_values);
      break;
    default:
      setting += word.value;
  }
  if (random.once_in(6)) damage_bytes(setting, setting, random);
  return setting;
}

}  // namespace mss::fuzz
