#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdint>
#include <string>

namespace mss::cli {

/// A check of a whole-number option: from `low` to `high`, both included. `zero` is what 0 stands for, as in
/// "all cores", where 0 is allowed too. Text that is no number is left to the option's own conversion.
inline CLI::Validator whole_number(std::int64_t low, std::int64_t high, const std::string& zero = {}) {
  return {[=](const std::string& text) -> std::string {
            std::int64_t value = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
            if (end != text.data() + text.size() || error == std::errc::invalid_argument) return {};
            if (error == std::errc() && ((low <= value && value <= high) || (value == 0 && !zero.empty())))
              return {};
            return fmt::format("{} is out of range; give a number from {} to {}{}", text, low, high,
                               zero.empty() ? "" : ", or 0 for " + zero);
          },
          ""};
}

}  // namespace mss::cli
