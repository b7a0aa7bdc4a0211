#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiments/harness/journal.hpp"
#include "experiments/harness/progress.hpp"

namespace mss {

/// A question with a name, and what answers it.
struct Case {
  std::string name;
  std::function<Json()> answer;
};

/// Finds the answers to all cases that the journal does not have yet, over so many processes, and adds
/// them to it in the order they are found; an answer depends on its case alone, so that how many processes
/// there are changes nothing. Numbers that are not finite become null; `processes` 0 means as many as cores.
/// False if stopped before the end: what has been found is kept. Throws std::runtime_error if a case does, or
/// if its process dies.
///
/// Processes are forked: systems belong inside `answer`, and have one thread, because threads of the caller
/// do not come along.
bool find_answers(const std::vector<Case>& cases, int processes, Journal& journal, Progress& progress);

}  // namespace mss
