#pragma once

#include <string>

namespace mss::cli {

// Quantities with their units, as options take them. Each throws InputError with one sentence that names the
// option, the text and what is allowed.

/// A share above 0 and below 1, as in "1%" or "0.01".
double read_share(const std::string& option, const std::string& text);

/// A length, as in "1mm", "2cm", "5um" or "0.001m"; without a unit metres. Returns metres.
double read_length(const std::string& option, const std::string& text);

/// Time that computing may take, as in "16.7ms/frame" of 1/60 s, or "0.5s/s". Returns seconds per simulated
/// second.
double read_budget(const std::string& text);

}  // namespace mss::cli
