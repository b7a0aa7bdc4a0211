#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/harness/progress.hpp"
#include "experiments/harness/table.hpp"

namespace mss {

/// How far a number may move from its baseline: by `relative` of the baseline or by `absolute`, whichever is
/// more. Columns without a rule must be the same to the letter.
struct ColumnRule {
  std::string column;
  double relative = 0;
  double absolute = 0;
};

struct GuardOptions {
  bool quick = false;
  int threads = 1;  ///< of the core; the table must not depend on it
};

/// What `mss check` guards of an experiment: a table that is the same on every machine, up to rounding.
struct Guard {
  std::vector<std::string> keys;  ///< columns that together name a row
  std::vector<ColumnRule> rules;  ///< of the others
  std::function<Table(const GuardOptions&, Progress&)> table;
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

/// A number that a table must hold because it is right, whoever computes it: from a closed form, finite
/// elements, or a converged reference. Unlike a baseline it is never promoted.
struct Truth {
  std::string table;  ///< name of its file, without extension
  std::string row;    ///< its keys, as in Deviation
  std::string column;
  double value = 0;
  double relative = 0, absolute = 0;  ///< how far the number may be off, whichever is more
  std::string source;
};

/// Reads a CSV file of truths, columns as the members above. Throws InputError naming file and line.
std::vector<Truth> read_truths(const std::filesystem::path& file);

/// Judges the table of that name, as CSV. Truths about other tables are passed over.
std::vector<Deviation> judge(const std::vector<Truth>& truths, const std::string& table, std::string_view now,
                             const Guard& guard);

/// A deviation as one line; `before` is introduced as what it "was", or "should be".
std::string to_string(const Deviation& deviation, std::string_view introduction = "was");

}  // namespace mss
