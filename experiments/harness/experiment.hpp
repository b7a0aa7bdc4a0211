#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.hpp"
#include "experiments/harness/baseline.hpp"
#include "experiments/harness/case_part.hpp"
#include "experiments/harness/journal.hpp"
#include "experiments/harness/json.hpp"
#include "experiments/harness/progress.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/plot/chart.hpp"
#include "experiments/plot/map_chart.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Options of an experiment.
struct ExperimentOptions {
  bool quick = false;
  std::vector<int> cells = {};                ///< cells per edge; empty: the experiment's own
  std::vector<std::string> integrators = {};  ///< names; empty: all
  std::vector<std::string> scenes = {};       ///< names; empty: the experiment's own choice
  int threads = 0;                            ///< most threads of the core; 0: all cores
  std::string model = spring_model;           ///< of the bodies' material
  std::uint64_t seed = 1;
  std::vector<std::string> settings = {};  ///< "table.key=value", of the scenes that it computes
  bool peers = false;                      ///< other programs too, where they are installed
  bool devices = false;                    ///< what devices do, and nothing else
  int processes = 0;                       ///< over which cases are split; 0: all cores
  CasePart part = {};                      ///< of the cases, those that are computed
  std::filesystem::path journal = {};      ///< file for results of finished cases; empty: none
};

/// Which of these apply to an experiment; the others are usage errors. All take --quick and --out.
struct ExperimentAccepts {
  bool cells = false;
  int largest_cells = 0;  ///< of any item of --cells
  /// Which integrators of those named, all if none is; throws InputError for others.
  std::vector<std::string> (*integrators)(const std::vector<std::string>& named) = nullptr;
  /// The names of all scenes that it knows.
  std::vector<std::string> (*scenes)() = nullptr;
  bool model = false;
  bool threads = false;
  bool seed = false;
  bool settings = false;
  bool peers = false;
  void (*devices)() = nullptr;  ///< throws InputError where there is none to measure
  bool processes = false;       ///< and keeps a journal, so that an interrupted run can be continued
};

struct NamedTable {
  std::string name;  ///< of the file, without extension
  Table table;
};

/// The table of a name. Throws InputError if there is none, as in an incomplete results directory.
const Table& find_table(const std::vector<NamedTable>& tables, std::string_view name);

/// The same of a table that results of older versions lack: nullptr if there is none, or if it has no rows.
const Table* rows_of(const std::vector<NamedTable>& tables, std::string_view name);

struct NamedChart {
  std::string name;  ///< of the files, without extension
  Chart chart;
  std::string table = {};  ///< most of what it shows; empty: see table_of()
};

struct NamedMap {
  std::string name;  ///< of the files, without extension
  MapChart chart;
  std::string table = {};  ///< as of a chart
};

/// The table that a chart shows, if that is not said: of those whose name the chart's begins with, the one of
/// the longest name, as `timing_features` for `timing_features_7`. Empty if there is none.
std::string table_of(std::string_view chart, const std::vector<NamedTable>& tables);

/// The charts of an experiment: the first has the experiment's name, if there is only one or there are no
/// maps.
struct Drawings {
  std::vector<NamedChart> charts = {};
  std::vector<NamedMap> maps = {};
};

/// Results of an experiment; report.hpp writes them to files. After an interruption, those that were
/// finished.
// NOLINTNEXTLINE(bugprone-exception-escape): moving ordered_json asserts, which the check takes for throwing
struct ExperimentResult {
  Status status = Status::ok;           ///< or interrupted
  std::vector<NamedTable> tables = {};  ///< the first has the experiment's name
  std::string caption;       ///< of the charts: what was done, what was held fixed, what was left out
  std::string summary = {};  ///< lines for stdout
  Json configuration;        ///< resolved: every choice with its value
};

/// An experiment, a pure function from options to results: it uses no globals, writes no file but the
/// journal, and prints only a notice when it continues from one.
struct ExperimentInfo {
  std::string name;
  std::string under = {};  ///< an experiment listed before, whose command is the first word of this one's
  std::string summary;     ///< one line for `mss list` and --help
  ExperimentAccepts accepts = {};
  bool times = false;  ///< its cases are compared by their times
  std::function<ExperimentResult(const ExperimentOptions&, Progress&)> run;
  /// The charts, from the tables alone, whether run() returned them or they were read from files.
  std::function<Drawings(const std::vector<NamedTable>&)> draw;
  Baseline baseline;  ///< what `mss check` compares

  /// The words after `mss` that run it.
  std::string command() const { return under.empty() ? name : under + " " + name; }
};

/// The integrators that an experiment on motion compares: those named, or all that move a material. Throws
/// InputError for unknown names and for methods that compute equilibria.
std::vector<std::string> moving_integrators(const std::vector<std::string>& named);
/// Of these, those that can move bodies of a model. Throws InputError if one that is named cannot.
std::vector<std::string> moving_integrators(const std::vector<std::string>& named, const std::string& model);
/// The same with the variants of methods beside those that they are of, where none is named.
std::vector<std::string> moving_families(const std::vector<std::string>& named);
std::vector<std::string> moving_families(const std::vector<std::string>& named, const std::string& model);
/// Of these, in their order, those that are no variant of another one among them: not `vbd:5` beside `vbd`.
std::vector<std::string> without_variants(const std::vector<std::string>& names);
/// Of moving_integrators(), those with a largest stable step. Throws InputError if one that is named has
/// none.
std::vector<std::string> limited_integrators(const std::vector<std::string>& named);

/// Throws InputError if one of the scenes that options name is not among those that an experiment knows, or
/// is named twice.
void check_scenes(const std::vector<std::string>& named, const std::vector<std::string>& known);

/// The journal that the options name, or one in memory. Throws as Journal() does.
Journal open_journal(const ExperimentOptions& options, const Json& configuration);

/// All experiments, in the order they are listed and reproduced.
const std::vector<ExperimentInfo>& experiments();

/// The experiment of a name. Throws InputError that suggests the nearest one if there is none.
const ExperimentInfo& find_experiment(std::string_view name);

}  // namespace mss
