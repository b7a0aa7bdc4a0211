#include "experiments/report.hpp"

#include <fmt/format.h>

#include <chrono>

#include "core/error.hpp"
#include "experiments/output.hpp"

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

}  // namespace

Report run_and_write(const ExperimentInfo& info, const ExperimentOptions& options,
                     const fs::path& directory) {
  prepare_directory(directory);
  Report report{.name = info.name, .provenance = provenance()};
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
  for (const NamedTable& t : result.tables) write(t.name + ".csv", t.table.csv());
  write("meta.json", meta(info, result, report.provenance, seconds).dump(2) + "\n");
  report.caption = result.caption;
  report.summary = result.summary;
  report.status = result.status;
  std::erase_if(result.charts, [](const NamedChart& c) { return !has_points(c.chart); });
  if (result.charts.empty()) {
    report.chart_problem = fmt::format("{}: there are too few rows for a chart", info.name);
    return report;
  }
  try {
    for (auto& [name, chart] : result.charts) {
      chart.footer = provenance_line(report.provenance);
      draw(chart, directory / name);
      report.files.push_back(directory / (name + ".svg"));
      report.files.push_back(directory / (name + ".png"));
    }
  } catch (const InputError& problem) {
    report.chart_problem = problem.what();
  }
  return report;
}

}  // namespace mss
