#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/harness/progress.hpp"
#include "experiments/harness/table.hpp"

namespace mss {

/// How far a number may move from its baseline: by `relative` times the baseline or by `absolute`, whichever
/// is more. Cells of columns without a rule must be identical.
struct ColumnRule {
  std::string column;
  double relative = 0;
  double absolute = 0;
  std::string only_of{};  ///< the first key of the rows it is for; empty: all that no rule before it is for
  /// Numbers above are failures, and alike: rounding, which differs between processors, decides how large.
  double failure = std::numeric_limits<double>::infinity();
};

struct BaselineOptions {
  bool quick = false;
  int threads =
      1;  ///< of one process, where a study has no worker processes; the table must not depend on it
};

/// What `mss check` reruns of an experiment and how it compares it: a table that is the same on every
/// machine, up to rounding.
struct Baseline {
  std::vector<std::string> keys;  ///< columns that together identify a row
  std::vector<ColumnRule> rules;  ///< of the others
  std::function<Table(const BaselineOptions&, Progress&)> table;
};

/// One difference between a table and its baseline.
struct Deviation {
  std::string row;     ///< its keys, as in "cells = 4, model = x"; empty: the whole table
  std::string column;  ///< empty: the whole row
  std::string before, now;
  std::string rule;  ///< the condition that is not met, in words
};

/// Compares two tables as CSV. Columns must be the same in the same order, both tables must have the same
/// rows in the same order, and every number must keep to its rule; numbers that are not finite never do.
std::vector<Deviation> compare(std::string_view before, std::string_view now, const Baseline& baseline);

inline constexpr std::string_view truth_ratio = " over ";

/// A number that a table must contain because it is right: from a closed form, finite elements, or a
/// converged reference. Unlike a baseline it is never promoted.
struct Truth {
  std::string table;  ///< name of its file, without extension
  /// Its keys, as in Deviation. Two rows joined by truth_ratio: the truth is about the ratio of their
  /// numbers, as that of two errors, which a method's order predicts.
  std::string row;
  std::string column;
  double value = 0;
  double relative = 0, absolute = 0;  ///< largest error allowed, whichever is more
  std::string source;
};

/// Reads a CSV file of truths, columns as the members above. Throws InputError naming file and line.
std::vector<Truth> read_truths(const std::filesystem::path& file);

/// Compares the table of that name, as CSV, with the truths about it; truths about other tables are ignored.
std::vector<Deviation> compare_with_truths(const std::vector<Truth>& truths, const std::string& table,
                                           std::string_view now, const Baseline& baseline);

/// A deviation as one line; `introduction` goes before the expected value: "was" or "should be".
std::string to_string(const Deviation& deviation, std::string_view introduction = "was");

}  // namespace mss
