#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace mss {

/// Reads a text word by word and knows in which line it is. Lines end in LF, CR LF or CR; a backslash at the
/// end of a line joins it with the next; what follows the character `comment` is left out, and a byte-order
/// mark at the beginning.
class TextScanner {
 public:
  explicit TextScanner(std::string_view text, char comment = '\0')
      : text_(text), comment_(comment), at_(text.starts_with("\xef\xbb\xbf") ? 3 : 0) {}

  /// The next word of this line; empty at its end.
  std::string_view word_in_line();
  /// The next word of this line or a later one; empty at the end of the text.
  std::string_view word();
  /// Goes to the beginning of the next line; false at the end of the text.
  bool next_line();

  std::size_t line() const { return line_; }  ///< counted from 1
  std::size_t position() const { return at_; }

  /// A word as a number, NaN and infinities included. Throws InputError with the line for another word.
  double number(std::string_view word) const;
  std::int64_t whole_number(std::string_view word, const char* of_what) const;

  /// Throws InputError: the line, and a sentence.
  [[noreturn]] void refuse(const std::string& sentence) const;

 private:
  bool at_line_end() const { return text_[at_] == '\n' || text_[at_] == '\r'; }
  bool at_blank() const { return std::string_view(" \t\v\f").find(text_[at_]) != std::string_view::npos; }
  bool at_joint() const;
  void pass_line_end();

  std::string_view text_;
  char comment_;
  std::size_t at_;
  std::size_t line_ = 1;
};

}  // namespace mss
