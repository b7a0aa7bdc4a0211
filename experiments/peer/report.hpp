#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"
#include "experiments/peer/verdict.hpp"

namespace mss::peer {

/// A result with all that is said of it. Its samples may be gone.
struct Judged {
  Result result;
  Score score;
  std::vector<Check> checks;
};

/// Scores of results, and without its samples each; `limits` as the user gave them.
Judged judged(const Judge& judge, Result result, const Limits& limits);

/// What tells a result from others of its engine beside step and iterations: those of its settings that are
/// not the same in all of them, in a line; empty: nothing.
std::string setting_of(const Result& result, const std::vector<Judged>& all);

/// `scores`, a row a result, with the columns that the scene has, and where some results of an engine differ
/// in nothing but the step, `stability`: the largest step up to which none of those tried failed, and the
/// smallest that did.
std::vector<NamedTable> score_tables(const Judge& judge, const std::vector<Judged>& results);

/// Error against processor time of a frame, from the tables.
Drawings draw(const std::vector<NamedTable>& tables);

/// Verdict, scores and checks for other programs; numbers that do not exist are null.
Json to_json(const Judge& judge, const std::vector<Judged>& results, const Limits& limits,
             const Json& origin);
/// The same as JUnit's XML: a test case for every check of every result.
std::string to_junit(const Judge& judge, const std::vector<Judged>& results);

/// Writes the tables, meta.json and the chart to a directory. Throws InputError if that fails; why there is
/// no chart it returns, in words: verdicts do not depend on gnuplot.
std::string write_scores(const Judge& judge, const std::vector<Judged>& results, const Limits& limits,
                         const Json& origin, const std::filesystem::path& directory);

/// Lines for stdout.
std::string summary(const Judge& judge, const std::vector<Judged>& results);

}  // namespace mss::peer
