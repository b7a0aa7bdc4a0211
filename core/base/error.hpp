#pragma once

#include <stdexcept>
#include <string>

namespace mss {

/// A text as one line that a terminal shows and does not obey: control characters become spaces, what is no
/// UTF-8 becomes U+FFFD, and of a text above 2000 bytes the middle is left out. Whatever a file holds, a
/// message may quote it.
std::string printable(const std::string& text);

/// The user gave something the program cannot use. The message is one sentence that names the place
/// (file, line, key), what was found and what is allowed, as printable() leaves it; the program ends with
/// exit status 2.
struct InputError : std::runtime_error {
  explicit InputError(const std::string& sentence) : std::runtime_error(printable(sentence)) {}
};

}  // namespace mss
