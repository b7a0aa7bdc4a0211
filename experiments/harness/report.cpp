#include "experiments/harness/report.hpp"

#include <fmt/format.h>

#include <chrono>

#include "core/error.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "experiments/plot/gnuplot.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

/// Units by column; columns without one are names, counts or ratios.
Json units(const Table& table) {
  Json out = Json::object();
  for (const Column& column : table.columns())
    if (!column.unit.empty()) out[column.name] = column.unit;
  return out;
}

Json meta(const ExperimentInfo& info, const ExperimentResult& result, const Json& origin, double seconds) {
  Json tables = Json::object();
  for (const NamedTable& t : result.tables)
    tables[t.name + ".csv"] = {{"rows", t.table.size()}, {"units", units(t.table)}};
  Json provenance = origin;
  provenance["load_average_end"] = load_average();
  return {{"experiment", info.name}, {"status", to_string(result.status)},    {"caption", result.caption},
          {"wall_seconds", seconds}, {"configuration", result.configuration}, {"tables", tables},
          {"provenance", provenance}};
}

/// Draws all charts and maps that have something on them.
void draw_charts(ExperimentResult& result, const fs::path& directory, Report& report) {
  const auto draw_one = [&](auto& named) {
    named.chart.footer = provenance_line(report.provenance);
    draw(named.chart, directory / named.name);
    report.files.push_back(directory / (named.name + ".svg"));
    report.files.push_back(directory / (named.name + ".png"));
  };
  std::erase_if(result.charts, [](const NamedChart& c) { return !has_points(c.chart); });
  std::erase_if(result.maps, [](const NamedMap& m) { return !has_cells(m.chart); });
  if (result.charts.empty() && result.maps.empty()) {
    report.chart_problem = fmt::format("{}: there are too few rows for a chart", report.name);
    return;
  }
  try {
    for (NamedChart& chart : result.charts) draw_one(chart);
    for (NamedMap& map : result.maps) draw_one(map);
  } catch (const InputError& problem) {
    report.chart_problem = problem.what();
  }
}

}  // namespace

Report run_and_write(const ExperimentInfo& info, ExperimentOptions options, const fs::path& directory) {
  prepare_directory(directory);
  if (info.accepts.processes) options.journal = directory / (info.name + ".journal");
  Report report{.name = info.name, .resumable = info.accepts.processes, .provenance = provenance()};
  const auto start = std::chrono::steady_clock::now();
  ExperimentResult result;
  {
    TerminalProgress progress(info.name);
    result = info.run(options, progress);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto write = [&](const std::string& name, const std::string& content) {
    write_atomically(directory / name, content);
    report.files.push_back(directory / name);
  };
  if (info.draw) {
    Drawings drawings = info.draw(result.tables);
    result.charts = std::move(drawings.charts);
    result.maps = std::move(drawings.maps);
  }
  for (const NamedTable& t : result.tables) write(t.name + ".csv", t.table.csv());
  write("meta.json", meta(info, result, report.provenance, seconds).dump(2) + "\n");
  if (result.status == Status::ok && !options.journal.empty()) fs::remove(options.journal);
  report.caption = result.caption;
  report.summary = result.summary;
  report.status = result.status;
  draw_charts(result, directory, report);
  return report;
}

}  // namespace mss
