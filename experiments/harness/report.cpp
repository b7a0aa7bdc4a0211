#include "experiments/harness/report.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/harness/results_folder.hpp"
#include "experiments/io/output.hpp"
#include "experiments/plot/gnuplot.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

Json meta(const ExperimentInfo& info, const ExperimentResult& result, const Json& origin, double seconds) {
  Json provenance = origin;
  provenance["load_average_end"] = load_average();
  return {{"experiment", info.name},
          {"status", to_string(result.status)},
          {"caption", result.caption},
          {"wall_seconds", seconds},
          {"configuration", result.configuration},
          {"tables", describe_tables(result.tables)},
          {"provenance", provenance}};
}

}  // namespace

Report run_and_write(const ExperimentInfo& info, ExperimentOptions options, const fs::path& directory) {
  prepare_directory(directory);
  if (info.accepts.processes) options.journal = directory / (info.name + ".journal");
  Report report{.name = info.name, .resumable = info.accepts.processes, .provenance = provenance()};
  ExperimentResult result;
  const double seconds = seconds_of([&] {
    TerminalProgress progress(info.name);
    result = info.run(options, progress);
  });
  const auto write = [&](const std::string& name, const std::string& content) {
    write_atomically(directory / name, content);
    report.files.push_back(directory / name);
  };
  for (const NamedTable& t : result.tables) write(t.name + ".csv", t.table.csv());
  write("meta.json", meta(info, result, report.provenance, seconds).dump(2) + "\n");
  if (result.status == Status::ok && !options.journal.empty()) fs::remove(options.journal);
  report.caption = result.caption;
  report.summary = result.summary;
  report.status = result.status;
  try {
    const std::vector<fs::path> pictures =
        write_drawings(info.draw(result.tables), report.provenance, directory);
    report.files.insert(report.files.end(), pictures.begin(), pictures.end());
    if (pictures.empty()) report.chart_problem = info.name + ": there are too few rows for a chart";
  } catch (const InputError& problem) {
    report.chart_problem = problem.what();
  }
  return report;
}

std::vector<fs::path> write_drawings(Drawings drawings, const Json& provenance, const fs::path& directory) {
  const TemporaryDirectory scratch;
  std::vector<std::string> names;
  const auto draw_one = [&](auto& named) {
    named.chart.footer = provenance_line(provenance);
    draw(named.chart, scratch.path() / named.name);
    names.push_back(named.name + ".svg");
    names.push_back(named.name + ".png");
  };
  for (NamedChart& chart : drawings.charts)
    if (has_points(chart.chart)) draw_one(chart);
  for (NamedMap& map : drawings.maps)
    if (has_cells(map.chart)) draw_one(map);
  std::vector<fs::path> files;
  for (const std::string& name : names) {
    files.push_back(directory / name);
    write_atomically(files.back(), read_file(scratch.path() / name));
  }
  return files;
}

}  // namespace mss
