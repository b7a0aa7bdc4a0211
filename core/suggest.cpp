#include "core/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "core/error.hpp"

namespace mss {

namespace {

constexpr std::size_t longest_name = 100;  ///< more would take time in proportion

/// Levenshtein distance, one row of the table at a time.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

bool begins(std::string_view found, std::string_view name) {
  return found.size() >= 3 && name.starts_with(found);
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
  if (begins(a, b)) return true;
  constexpr std::size_t two_letters = 2;  // as where they changed places in a short name
  const std::size_t longer = std::max(a.size(), b.size());
  return longer <= longest_name && edit_distance(a, b) <= std::max(two_letters, longer / 2);
}

void throw_unknown(std::string_view name, const std::vector<std::string>& known, std::string_view what,
                   std::string_view list) {
  const std::string near = nearest(name, known);
  const std::string question = are_alike(name, near) ? fmt::format("did you mean '{}'? ", near) : "";
  throw InputError(fmt::format("{} '{}' is unknown; {}`mss list {}` shows all", what, name, question, list));
}

}  // namespace mss
