#include "core/mesh/text_scanner.hpp"

#include <fmt/format.h>

#include <charconv>
#include <limits>

#include "core/base/error.hpp"

namespace mss {

bool TextScanner::at_joint() const {
  return text_[at_] == '\\' && at_ + 1 < text_.size() && (text_[at_ + 1] == '\n' || text_[at_ + 1] == '\r');
}

void TextScanner::pass_line_end() {
  const bool two = text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n';
  at_ += two ? 2 : 1;
  ++line_;
}

std::string_view TextScanner::word_in_line() {
  while (at_ < text_.size() && (at_blank() || at_joint())) {
    if (at_joint()) {
      ++at_;
      pass_line_end();
    } else {
      ++at_;
    }
  }
  const std::size_t begin = at_;
  const auto is_comment = [&] { return comment_ != '\0' && text_[at_] == comment_; };
  while (at_ < text_.size() && !at_blank() && !at_line_end() && !at_joint() && !is_comment()) ++at_;
  return text_.substr(begin, at_ - begin);
}

std::string_view TextScanner::word() {
  while (true) {
    if (const std::string_view word = word_in_line(); !word.empty()) return word;
    if (!next_line()) return {};
  }
}

bool TextScanner::next_line() {
  while (!word_in_line().empty()) {
  }
  while (at_ < text_.size() && !at_line_end()) ++at_;  // a comment
  if (at_ == text_.size()) return false;
  pass_line_end();
  return at_ < text_.size();
}

double TextScanner::number(std::string_view word) const {
  const std::string_view digits = word.substr(word.starts_with('+') ? 1 : 0);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (digits.empty() || end != digits.data() + digits.size() || error == std::errc::invalid_argument)
    refuse(fmt::format("'{}' is no number; give one such as -0.5 or 1e-3, with a decimal point",
                       word.substr(0, 40)));
  if (error == std::errc::result_out_of_range) {
    const bool tiny =
        digits.find("e-") != std::string_view::npos || digits.find("E-") != std::string_view::npos;
    return tiny ? 0 : std::numeric_limits<double>::infinity();
  }
  return value;
}

std::int64_t TextScanner::whole_number(std::string_view word, const char* of_what) const {
  const std::string_view digits = word.substr(word.starts_with('+') ? 1 : 0);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size())
    refuse(fmt::format("gives '{}' as {}; give a whole number", word.substr(0, 40), of_what));
  return value;
}

void TextScanner::refuse(const std::string& sentence) const {
  throw InputError(fmt::format("line {}: {}", line_, sentence));
}

}  // namespace mss
