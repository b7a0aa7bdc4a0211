#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "experiments/harness/other_work.hpp"
#include "experiments/harness/report.hpp"

namespace mss {

/// Reads "i/N", the i-th of N parts. Throws InputError for anything else.
CasePart parse_part(std::string_view text);

/// Runs the part of an experiment that the options name. In a directory it leaves the results of its cases,
/// NAME.journal, and once they are complete `part.json` with the experiment, the part, its options and its
/// provenance; no tables.
Report run_part(const ExperimentInfo& info, ExperimentOptions options,
                const std::filesystem::path& directory);

/// All parts of an experiment, complete, as run_part() left them.
struct PartsFound {
  const ExperimentInfo* info;
  ExperimentOptions options;
  std::optional<OtherWork> other_work{};  ///< the most that ran beside a part
};

/// Reads the parts in these directories and writes their results together to a journal in `directory`, so
/// that run_and_write() with these options makes what one run would have made. Throws InputError, with the
/// directories, if there is no part in one, if they are of different experiments, options or commits, or of
/// another commit than this program, if a part is missing or there twice, or if they contain times of
/// different machines.
PartsFound merge_parts(const std::vector<std::filesystem::path>& directories,
                       const std::filesystem::path& directory);

}  // namespace mss
