#include "experiments/cli/quantities.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.hpp"
#include "experiments/advise/trajectory.hpp"

namespace mss::cli {

namespace {

/// The number a text begins with, and what follows; nothing if it does not begin with one.
std::optional<std::pair<double, std::string>> number_and_rest(const std::string& text) {
  double value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || !std::isfinite(value)) return {};
  return std::pair(value, std::string(end, text.data() + text.size()));
}

/// What a positive number with one of some units is in the first one's; nothing for other texts.
std::optional<double> positive_in(const std::string& text,
                                  const std::vector<std::pair<std::string, double>>& units) {
  const auto read = number_and_rest(text);
  for (const auto& [unit, factor] : units)
    if (read && read->second == unit && read->first > 0) return read->first * factor;
  return {};
}

}  // namespace

double read_share(const std::string& option, const std::string& text) {
  const auto share = positive_in(text, {{"", 1}, {"%", 1e-2}});
  if (!share || *share >= 1)
    throw InputError(
        fmt::format("{} {} is not a share; give one above 0 and below 100 %, as in 1%", option, text));
  return *share;
}

double read_length(const std::string& option, const std::string& text) {
  const auto length = positive_in(text, {{"", 1}, {"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}});
  if (!length)
    throw InputError(fmt::format(
        "{} {} is not a length; give a positive number of m, cm, mm or um, as in 1mm", option, text));
  return *length;
}

double read_budget(const std::string& text) {
  constexpr double frames = advise::frames_per_second;
  const auto budget = positive_in(text, {{"ns/frame", 1e-9 * frames},
                                         {"us/frame", 1e-6 * frames},
                                         {"ms/frame", 1e-3 * frames},
                                         {"s/frame", frames},
                                         {"s/s", 1}});
  if (!budget)
    throw InputError(fmt::format(
        "--budget {} is not a time; give a positive number of ms/frame (of which there are {:.0f} "
        "to a simulated second), us/frame, ns/frame, s/frame or s/s, as in 16.7ms/frame",
        text, frames));
  return *budget;
}

}  // namespace mss::cli
