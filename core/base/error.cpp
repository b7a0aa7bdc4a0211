#include "core/base/error.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace mss {

namespace {

constexpr std::size_t longest_line = 2000;  ///< bytes
constexpr std::string_view no_character = "\xef\xbf\xbd";

unsigned byte_at(std::string_view text, std::size_t i) { return static_cast<unsigned char>(text[i]); }

/// Bytes of the UTF-8 character that begins a text which is not empty; 0 if none does.
std::size_t character_size(std::string_view text) {
  struct Range {
    unsigned first, last;                 ///< of the first byte
    std::size_t size;                     ///< of the character
    unsigned lower = 0x80, upper = 0xbf;  ///< of the second byte
  };
  // Table 3-7 of the Unicode standard: no character twice, no surrogates, none beyond U+10FFFF
  constexpr std::array<Range, 9> ranges{{{0x00, 0x7f, 1},
                                         {0xc2, 0xdf, 2},
                                         {0xe0, 0xe0, 3, 0xa0, 0xbf},
                                         {0xe1, 0xec, 3},
                                         {0xed, 0xed, 3, 0x80, 0x9f},
                                         {0xee, 0xef, 3},
                                         {0xf0, 0xf0, 4, 0x90, 0xbf},
                                         {0xf1, 0xf3, 4},
                                         {0xf4, 0xf4, 4, 0x80, 0x8f}}};
  const unsigned first = byte_at(text, 0);
  const auto range = std::find_if(ranges.begin(), ranges.end(),
                                  [&](const Range& r) { return first >= r.first && first <= r.last; });
  if (range == ranges.end() || range->size > text.size()) return 0;
  for (std::size_t i = 1; i < range->size; ++i) {
    const unsigned lower = i == 1 ? range->lower : 0x80, upper = i == 1 ? range->upper : 0xbf;
    if (byte_at(text, i) < lower || byte_at(text, i) > upper) return 0;
  }
  return range->size;
}

/// U+0000 to U+001F and U+007F to U+009F.
bool is_control(std::string_view character) {
  const unsigned first = byte_at(character, 0);
  return first < 0x20 || first == 0x7f || (first == 0xc2 && byte_at(character, 1) < 0xa0);
}

/// The place stands at the beginning of a message, the remedy at its end.
std::string without_middle(const std::string& text) {
  if (text.size() <= longest_line) return text;
  constexpr std::string_view gap = " ... ";
  constexpr std::size_t kept = (longest_line - gap.size()) / 2;
  const auto is_inside = [&](std::size_t i) { return (byte_at(text, i) & 0xc0U) == 0x80U; };
  std::size_t begin = kept, end = text.size() - kept;
  while (is_inside(begin)) --begin;
  while (end < text.size() && is_inside(end)) ++end;
  return text.substr(0, begin) + std::string(gap) + text.substr(end);
}

}  // namespace

std::string printable(const std::string& text) {
  std::string line;
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view rest = std::string_view(text).substr(i);
    const std::size_t size = character_size(rest);
    if (size == 0)
      line += no_character;
    else if (is_control(rest.substr(0, size)))
      line += ' ';
    else
      line += rest.substr(0, size);
    i += std::max(size, std::size_t{1});
  }
  return without_middle(line);
}

}  // namespace mss
