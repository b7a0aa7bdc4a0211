#pragma once

#include <string_view>

namespace mss {

/// One of `count` runs that share the cases of an experiment between them, on one machine or on many. Cases
/// of one group belong to the same part: those of which some depend on the results of others.
struct CasePart {
  int index = 1;
  int count = 1;

  /// Whether a group belongs to it; an empty name is that of cases which every part needs.
  bool has(std::string_view group) const;
  bool is_whole() const { return count == 1; }
};

}  // namespace mss
