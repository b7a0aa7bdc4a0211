#pragma once

#include <regex>
#include <string>
#include <vector>

namespace mss::testing {

/// All texts that the first group of a pattern matches.
inline std::vector<std::string> matches(const std::string& text, const char* pattern) {
  const std::regex expression(pattern);
  std::vector<std::string> all;
  for (std::sregex_iterator i(text.begin(), text.end(), expression), end; i != end; ++i)
    all.push_back((*i)[1]);
  return all;
}

}  // namespace mss::testing
