#include "experiments/harness/report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "core/base/error.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/other_work.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/harness/results_folder.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

Json meta(const ExperimentInfo& info, const ExperimentOptions& options, const ExperimentResult& result,
          const Json& provenance, double seconds) {
  return {{"experiment", info.name},
          {"command", command_line(info, options)},
          {"status", to_string(result.status)},
          {"caption", result.caption},
          {"summary", result.summary},
          {"wall_seconds", seconds},
          {"configuration", result.configuration},
          {"tables", describe_tables(result.tables)},
          {"provenance", provenance}};
}

/// How many rows have which status, the most frequent first; empty if the table has no such column.
std::vector<std::pair<std::string, std::size_t>> count_outcomes(const Table& table) {
  const auto is_status = [](const Column& column) { return column.name == "status"; };
  if (std::none_of(table.columns().begin(), table.columns().end(), is_status)) return {};
  std::map<std::string, std::size_t> counts;
  for (std::size_t r = 0; r < table.size(); ++r) ++counts[table.text(r, "status")];
  std::vector<std::pair<std::string, std::size_t>> sorted(counts.begin(), counts.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  return sorted;
}

/// What can be said without the charts. Results of earlier versions have no command and no summary.
Report report_without_charts(const ExperimentInfo& info, const Json& meta,
                             const std::vector<NamedTable>& tables, const fs::path& directory) {
  Report report{.name = info.name, .question = info.summary, .directory = directory};
  report.command = meta.value("command", "mss " + info.command());
  report.caption = meta.value("caption", "");
  report.summary = meta.value("summary", "");
  report.status = meta.value("status", "ok") == to_string(Status::ok) ? Status::ok : Status::interrupted;
  report.resumable = info.accepts.processes;
  report.seconds = meta.value("wall_seconds", 0.0);
  report.provenance = meta.at("provenance");
  for (const NamedTable& named : tables) {
    report.tables.emplace_back(named.name, named.table.size());
    report.files.push_back(directory / (named.name + ".csv"));
  }
  report.files.push_back(directory / "meta.json");
  if (!tables.empty()) report.outcomes = count_outcomes(tables.front().table);
  return report;
}

}  // namespace

std::string command_line(const ExperimentInfo& info, const ExperimentOptions& options) {
  const ExperimentAccepts& accepts = info.accepts;
  const ExperimentOptions defaults;
  std::string line = "mss " + info.command();
  if (options.quick) line += " --quick";
  if (accepts.cells && !options.cells.empty())
    line += fmt::format(" --cells {}", fmt::join(options.cells, ","));
  if (accepts.integrators && !options.integrators.empty())
    line += fmt::format(" --integrators {}", fmt::join(options.integrators, ","));
  if (accepts.scenes && !options.scenes.empty())
    line += fmt::format(" --scenes {}", fmt::join(options.scenes, ","));
  if (accepts.model && options.model != defaults.model) line += " --model " + options.model;
  if (accepts.threads && options.threads != defaults.threads)
    line += fmt::format(" --threads {}", options.threads);
  if (accepts.peers && options.peers) line += " --peers";
  if (accepts.devices && options.devices) line += " --devices";
  if (accepts.seed && options.seed != defaults.seed) line += fmt::format(" --seed {}", options.seed);
  if (accepts.processes && options.processes != defaults.processes)
    line += fmt::format(" --processes {}", options.processes);
  for (const std::string& setting : options.settings) line += fmt::format(" --set '{}'", setting);
  return line;
}

Report run_and_write(const ExperimentInfo& info, ExperimentOptions options, const fs::path& directory,
                     const std::optional<OtherWork>& other_work) {
  prepare_directory(directory);
  const DirectoryClaim claim(directory);
  if (info.accepts.processes) options.journal = directory / (info.name + ".journal");
  Json origin = provenance();
  const OtherWorkWatch others;
  ExperimentResult result;
  const double seconds = seconds_of([&] {
    TerminalProgress progress(info.name);
    result = info.run(options, progress);
  });
  origin["load_average_end"] = load_average();
  origin["other_work"] = to_json(more_of(others.so_far(), other_work));
  const Json record = meta(info, options, result, origin, seconds);
  for (const NamedTable& t : result.tables) write_atomically(directory / (t.name + ".csv"), t.table.csv());
  write_atomically(directory / "meta.json", record.dump(2) + "\n");
  if (result.status == Status::ok && !options.journal.empty()) fs::remove(options.journal);
  Report report = report_without_charts(info, record, result.tables, directory);
  try {
    report.charts = write_drawings(info.draw(result.tables), result.tables, origin, directory);
    const std::vector<fs::path> pictures = files_of(report.charts, directory);
    report.files.insert(report.files.end(), pictures.begin(), pictures.end());
    if (pictures.empty()) report.chart_problem = info.name + ": there are too few rows for a chart";
  } catch (const InputError& problem) {
    report.chart_problem = problem.what();
  }
  return report;
}

Report redrawn_report(const ExperimentInfo& info, const fs::path& directory) {
  const ResultsFolder folder = read_results(directory);
  if (folder.experiment != info.name)
    throw InputError(
        fmt::format("{} has results of {}, not of {}", directory.string(), folder.experiment, info.name));
  Report report;
  try {
    report = report_without_charts(info, folder.meta, folder.tables, directory);
    provenance_line(folder.provenance);  // throws
  } catch (const Json::exception& problem) {
    throw InputError(fmt::format("{} is not the record of an experiment: {}",
                                 (directory / "meta.json").string(), problem.what()));
  }
  try {
    report.charts = redraw(folder, info.draw);
  } catch (const InputError& problem) {
    report.chart_problem = problem.what();
  }
  return report;
}

}  // namespace mss
