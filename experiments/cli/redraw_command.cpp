// `mss redraw`: draws charts again from their tables, and the page of several studies.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "core/base/error.hpp"
#include "experiments/advise/chart.hpp"
#include "experiments/advise/static_advice.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/fit/chart.hpp"
#include "experiments/harness/page.hpp"
#include "experiments/harness/results_folder.hpp"
#include "experiments/peer/report.hpp"

namespace mss::cli {

namespace {

namespace fs = std::filesystem;

using Draw = std::function<Drawings(const std::vector<NamedTable>&)>;

/// What draws the charts of a folder's experiment.
Draw draw_of(const ResultsFolder& folder) {
  if (folder.experiment == "advise") return advise::draw;
  if (folder.experiment == "fit") return fit::draw;
  if (folder.experiment == "static_advice") return advise::draw_at_rest;
  if (folder.experiment == "peer_score") return peer::draw;
  try {
    return find_experiment(folder.experiment).draw;
  } catch (const InputError& problem) {
    throw InputError(fmt::format("{}: {}", (folder.directory / "meta.json").string(), problem.what()));
  }
}

void print_written(const std::vector<DrawnChart>& charts, const fs::path& directory) {
  for (const fs::path& file : files_of(charts, directory)) fmt::print("wrote {}\n", file.string());
}

void redraw_directory(const fs::path& directory) {
  const ResultsFolder folder = read_results(directory);
  const Draw draw = draw_of(folder);
  try {
    print_written(redraw(folder, draw), directory);
  } catch (const InputError& problem) {
    throw InputError(fmt::format("{}: {}", directory.string(), problem.what()));
  }
}

/// Whether a directory has results of studies in folders of their names, as `mss reproduce` leaves them.
bool has_studies(const fs::path& directory) {
  const auto is_in = [&](const ExperimentInfo& info) { return has_results(directory / info.name); };
  return !has_results(directory) && std::any_of(experiments().begin(), experiments().end(), is_in);
}

/// Draws the charts of all studies in a directory, and their page.
void redraw_studies(const fs::path& directory, int& exit_status) {
  std::vector<Report> reports;
  for (const ExperimentInfo& info : experiments()) {
    if (!has_results(directory / info.name)) continue;
    const Report& report = reports.emplace_back(redrawn_report(info, directory / info.name));
    print_written(report.charts, report.directory);
    if (report.chart_problem.empty()) continue;
    fmt::print(stderr, "mss: {}: {}\n", report.name, report.chart_problem);
    exit_status = exit_bad_input;
  }
  write_page(reports, directory / "index.html");
  fmt::print("wrote {}\n", (directory / "index.html").string());
}

void add_redraw(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand("redraw", "draw the charts of results again from their tables");
  const auto directory = std::make_shared<std::string>();
  command
      ->add_option(
          "directory", *directory,
          "Directory with meta.json and tables, as an experiment wrote it, or with those of several, as "
          "`mss reproduce` left them; charts and page are replaced")
      ->required();
  command->callback([directory, &exit_status] {
    if (has_studies(*directory))
      redraw_studies(*directory, exit_status);
    else
      redraw_directory(*directory);
  });
}

}  // namespace

Command redraw_command() { return add_redraw; }

}  // namespace mss::cli
