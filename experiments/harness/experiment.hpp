#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene.hpp"
#include "experiments/harness/baseline.hpp"
#include "experiments/harness/journal.hpp"
#include "experiments/harness/json.hpp"
#include "experiments/harness/progress.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/plot/chart.hpp"
#include "experiments/plot/map_chart.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// What the command line lets a user choose about an experiment.
struct ExperimentOptions {
  bool quick = false;
  std::vector<int> cells = {};                ///< cells per edge; empty: the experiment's own
  std::vector<std::string> integrators = {};  ///< names; empty: all
  int threads = 0;                            ///< most threads of the core; 0: all cores
  std::string model = spring_model;           ///< what fills the bodies
  std::uint64_t seed = 1;
  int processes = 0;                   ///< over which cases are split; 0: all cores
  std::filesystem::path journal = {};  ///< of answers found so far; empty: none is kept
};

/// Which of these apply to an experiment; the others are usage errors. All take --quick and --out.
struct ExperimentAccepts {
  bool cells = false;
  int largest_cells = 0;  ///< of any item of --cells
  /// Which integrators of those named, all if none is; throws InputError for others.
  std::vector<std::string> (*integrators)(const std::vector<std::string>& named) = nullptr;
  bool model = false;
  bool threads = false;
  bool seed = false;
  bool processes = false;  ///< and it keeps a journal, so that it can be interrupted and go on
};

struct NamedTable {
  std::string name;  ///< of the file, without extension
  Table table;
};

/// The table of a name. Throws InputError if there is none, as where a folder of results is not complete.
const Table& find_table(const std::vector<NamedTable>& tables, std::string_view name);

struct NamedChart {
  std::string name;  ///< of the files, without extension
  Chart chart;
};

struct NamedMap {
  std::string name;  ///< of the files, without extension
  MapChart chart;
};

/// The charts of an experiment: the first has the experiment's name, if there is only one or there are no
/// maps.
struct Drawings {
  std::vector<NamedChart> charts = {};
  std::vector<NamedMap> maps = {};
};

/// What an experiment hands back; report.hpp turns it into files. An interrupted one hands back what it
/// finished.
// NOLINTNEXTLINE(bugprone-exception-escape): moving ordered_json asserts, which the check takes for throwing
struct ExperimentResult {
  Status status = Status::ok;           ///< or interrupted
  std::vector<NamedTable> tables = {};  ///< the first has the experiment's name
  std::vector<NamedChart> charts =
      {};                           ///< with maps: the first has the experiment's name, if there is only one
  std::vector<NamedMap> maps = {};  ///< further charts
  std::string caption;       ///< for a reader of the chart: what was done, what is held, what is left out
  std::string summary = {};  ///< lines for stdout
  Json configuration;        ///< resolved: every choice with its value
};

/// A pure function from options to result: no globals, no files but the journal, and nothing printed but that
/// one is gone on with.
struct ExperimentInfo {
  std::string name;
  std::string under = {};  ///< an experiment listed before, of whose command this one is the second word
  std::string summary;     ///< one line for `mss list` and --help
  ExperimentAccepts accepts;
  std::function<ExperimentResult(const ExperimentOptions&, Progress&)> run;
  /// The charts, from the tables alone, as run() returned them or as they were read from its files again.
  std::function<Drawings(const std::vector<NamedTable>&)> draw = {};
  Baseline baseline;  ///< what `mss check` compares

  /// How `mss` is asked for it.
  std::string command() const { return under.empty() ? name : under + " " + name; }
};

/// The methods an experiment on motion compares: those named, or all. Throws InputError for unknown names and
/// for methods that find no motion.
std::vector<std::string> moving_integrators(const std::vector<std::string>& named);
/// Of these, those with a largest step. Throws InputError for one named that has none.
std::vector<std::string> limited_integrators(const std::vector<std::string>& named);

/// The journal that the options ask for, or one of nothing on disk. Throws as Journal() does.
Journal open_journal(const ExperimentOptions& options, const Json& configuration);

/// All experiments, in the order they are listed and reproduced.
const std::vector<ExperimentInfo>& experiments();

/// The experiment of a name. Throws InputError that suggests the nearest one if there is none.
const ExperimentInfo& find_experiment(std::string_view name);

}  // namespace mss
