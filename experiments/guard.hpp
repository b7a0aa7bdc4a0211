#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/progress.hpp"
#include "experiments/table.hpp"

namespace mss {

/// How far a number may move from its baseline: by `relative` of the baseline or by `absolute`, whichever is
/// more. Columns without a rule must be the same to the letter.
struct ColumnRule {
  std::string column;
  double relative = 0;
  double absolute = 0;
};

/// What `mss check` guards of an experiment: a table that is the same on every machine, up to rounding.
struct Guard {
  std::vector<std::string> keys;  ///< columns that together name a row
  std::vector<ColumnRule> rules;  ///< of the others
  std::function<Table(bool quick, Progress&)> table;
};

/// One way in which a table is not what its baseline says.
struct Deviation {
  std::string row;     ///< its keys, as in "cells = 4, model = x"; empty: the whole table
  std::string column;  ///< empty: the whole row
  std::string before, now;
  std::string rule;  ///< what was asked of it, in words
};

/// Compares two tables as CSV. Columns must be the same in the same order, every row of the one be in the
/// other, in the same order, and every number follow its rule; a number that is not finite follows none.
std::vector<Deviation> compare(std::string_view baseline, std::string_view now, const Guard& guard);

/// A deviation as one line.
std::string to_string(const Deviation& deviation);

}  // namespace mss
