#include "core/base/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/base/error.hpp"

namespace mss {

namespace {

constexpr std::size_t longest_name = 100;  ///< more would take time in proportion

/// Letters inserted, deleted, replaced, or swapped with the next (optimal string alignment), by rows of its
/// table.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1), above, above_that;
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    above_that = std::exchange(above, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, replaced});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], above_that[j - 2] + 1);
    }
  }
  return row.back();
}

bool begins(std::string_view found, std::string_view name) {
  return found.size() >= 3 && name.starts_with(found);
}

std::size_t common_beginning(std::string_view a, std::string_view b) {
  const std::size_t both = std::min(a.size(), b.size());
  return std::size_t(std::mismatch(a.begin(), a.begin() + std::ptrdiff_t(both), b.begin()).first - a.begin());
}

}  // namespace

std::string nearest(std::string_view found, const std::vector<std::string>& known) {
  found = found.substr(0, longest_name);
  const auto closer = [&](const std::string& a, const std::string& b) {
    return edit_distance(found, a) < edit_distance(found, b);
  };
  const auto begun =
      std::find_if(known.begin(), known.end(), [&](const std::string& name) { return begins(found, name); });
  if (begun != known.end()) return *begun;
  const auto best = std::min_element(known.begin(), known.end(), closer);
  return best == known.end() ? std::string() : *best;
}

bool are_alike(std::string_view a, std::string_view b) {
  const std::size_t longer = std::max(a.size(), b.size());
  if (a.empty() || b.empty() || longer > longest_name) return false;
  if (begins(a, b) || 2 * common_beginning(a, b) > longer) return true;
  const std::size_t edits = edit_distance(a, b);
  return edits < longer && edits <= std::max(longer / 3, std::size_t{1});
}

std::string question(std::string_view found, const std::vector<std::string>& known) {
  const std::string near = nearest(found, known);
  return are_alike(found, near) ? fmt::format("did you mean '{}'? ", near) : "";
}

void throw_unknown(std::string_view name, const std::vector<std::string>& known, std::string_view what,
                   std::string_view list) {
  throw InputError(
      fmt::format("{} '{}' is unknown; {}`mss list {}` shows all", what, name, question(name, known), list));
}

}  // namespace mss
