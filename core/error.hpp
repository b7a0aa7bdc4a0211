#pragma once

#include <stdexcept>
#include <string>

namespace mss {

/// The user gave something the program cannot use. The message is one sentence that names the place
/// (file, line, key), what was found and what is allowed; the program ends with exit status 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace mss
