#include "experiments/cli/number_list.hpp"

#include <fmt/format.h>

#include <charconv>
#include <set>

#include "core/base/error.hpp"

namespace mss::cli {

namespace {

/// The one number that `text` is, or 0.
int whole_number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : 0;
}

}  // namespace

std::vector<int> parse_number_list(std::string_view text, std::string_view option, int largest) {
  std::set<int> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view item = text.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t colon = item.find(':');
    const int first = whole_number(item.substr(0, colon));
    const int last = colon == item.npos ? first : whole_number(item.substr(colon + 1));
    if (first < 1 || last < 1 || first > largest || last > largest)
      throw InputError(fmt::format("{} has the item '{}'; give numbers from 1 to {} and ranges, as in 2:4,8",
                                   option, item, largest));
    if (last < first)
      throw InputError(
          fmt::format("{} has the range '{}', which runs backwards; write {}:{}", option, item, last, first));
    for (int n = first; n <= last; ++n) numbers.insert(n);
  }
  return {numbers.begin(), numbers.end()};
}

}  // namespace mss::cli
