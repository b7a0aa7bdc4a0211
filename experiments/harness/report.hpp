#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "experiments/harness/drawings.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/other_work.hpp"

namespace mss {

/// The outcome of running one experiment and writing its files.
// NOLINTNEXTLINE(bugprone-exception-escape): as of ExperimentResult
struct Report {
  std::string name;
  std::string question = {};  ///< what the experiment is about, in a line
  std::string command = {};   ///< as one types it, but for --out
  std::string caption = {};
  std::string summary = {};
  Status status = Status::ok;
  bool resumable = false;  ///< if interrupted, the same command continues from its journal
  double seconds = 0;      ///< wall time
  std::filesystem::path directory = {};
  std::vector<std::filesystem::path> files = {};  ///< as written, the tables first
  std::vector<std::pair<std::string, std::size_t>> tables =
      {};  ///< names and numbers of rows, the main one first
  std::vector<std::pair<std::string, std::size_t>> outcomes =
      {};  ///< rows of the main table by status, most first
  std::vector<DrawnChart> charts = {};
  std::string chart_problem = {};  ///< why there is no chart; empty if there is one
  Json provenance = {};
};

/// Runs an experiment with a progress line and writes its tables, meta.json and its charts to `directory`,
/// tables first. Throws InputError before anything is run if the directory cannot be written to. The journal
/// of an experiment that keeps one is there until the run is complete. `other_work`: what ran beside what the
/// journal has already.
Report run_and_write(const ExperimentInfo& info, ExperimentOptions options,
                     const std::filesystem::path& directory, const std::optional<OtherWork>& other_work = {});

/// The report of an experiment that was run before, from what it left; its charts are drawn again.
Report redrawn_report(const ExperimentInfo& info, const std::filesystem::path& directory);

/// The command that runs an experiment with these options, as one types it; without --out.
std::string command_line(const ExperimentInfo& info, const ExperimentOptions& options);

}  // namespace mss
