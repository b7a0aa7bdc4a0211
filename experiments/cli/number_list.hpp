#pragma once

#include <string_view>
#include <vector>

namespace mss::cli {

/// Reads a list such as "2:15,20,30": numbers from 1 to `largest` and ranges with both ends included. Returns
/// them ascending and once each. Throws InputError that quotes the item that is wrong; `option` is the name
/// of the option in that message.
std::vector<int> parse_number_list(std::string_view text, std::string_view option, int largest);

}  // namespace mss::cli
