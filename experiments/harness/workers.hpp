#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiments/harness/journal.hpp"
#include "experiments/harness/progress.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// A computation with the name that its result has in the journal.
struct Case {
  std::string name;
  std::function<Json()> compute;
  std::string group = {};  ///< of cases that belong to one part of a run; see CasePart
};

/// Leaves out cases that belong to other parts of the journal's run than its own.
std::vector<Case> own_cases(std::vector<Case> cases, const Journal& journal);

/// Computes all cases that the journal has no result of, over so many processes (0: one per core), and adds
/// the results in the order in which they finish. A result must depend on its case alone; then it is the same
/// for any number of processes. Numbers that are not finite become null. False if `progress` stopped it
/// before the end: results so far are kept. Throws InputError if a case does, and std::runtime_error if it
/// throws anything else or its process is killed.
///
/// Processes are forked, and a fork has none of its parent's threads: create systems inside `compute`, with
/// one thread.
bool compute_cases(const std::vector<Case>& cases, int processes, Journal& journal, Progress& progress);

/// Computes the cases that belong to the journal's part, as compute_cases(), and passes the results there are
/// then, of other parts too, to `use` in the order of the cases.
Status gather_cases(const std::vector<Case>& cases, int processes, Journal& journal, Progress& progress,
                    const std::function<void(const Json&)>& use);

}  // namespace mss
