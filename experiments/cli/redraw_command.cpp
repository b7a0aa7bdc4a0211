// `mss redraw`: draws the charts of a results directory again from its tables.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "core/error.hpp"
#include "experiments/advise/chart.hpp"
#include "experiments/advise/static_advice.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/harness/results_folder.hpp"

namespace mss::cli {

namespace {

using Draw = std::function<Drawings(const std::vector<NamedTable>&)>;

/// What draws the charts of a folder's experiment.
Draw draw_of(const ResultsFolder& folder) {
  if (folder.experiment == "advise") return advise::draw;
  if (folder.experiment == "static_advice") return advise::draw_at_rest;
  try {
    return find_experiment(folder.experiment).draw;
  } catch (const InputError& problem) {
    throw InputError(fmt::format("{}: {}", (folder.directory / "meta.json").string(), problem.what()));
  }
}

void redraw_directory(const std::string& directory) {
  const ResultsFolder folder = read_results(directory);
  for (const std::filesystem::path& file : redraw(folder, draw_of(folder)))
    fmt::print("wrote {}\n", file.string());
}

void add(CLI::App& app, int&) {
  CLI::App* command =
      app.add_subcommand("redraw", "draw the charts of a results directory again from its tables");
  const auto directory = std::make_shared<std::string>();
  command
      ->add_option("directory", *directory,
                   "Directory with meta.json and tables, as an experiment wrote it; its charts are replaced")
      ->required();
  command->callback([directory] { redraw_directory(*directory); });
}

}  // namespace

Command redraw_command() { return add; }

}  // namespace mss::cli
