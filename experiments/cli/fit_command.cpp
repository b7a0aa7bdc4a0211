// `mss fit`: the numbers of a scene that make it fit what was measured.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "core/base/error.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/fit/report.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/scene_files.hpp"

namespace mss::cli {

namespace {

struct FitChoice {
  std::string scene;
  std::string data;
  std::vector<std::string> parameters;
  std::vector<std::string> overrides;
  std::vector<std::string> coarse;
  double most_evaluations = 30;
  std::string directory;
};

fit::FitProblem read_fit(const FitChoice& choice) {
  if (!(choice.most_evaluations >= 1))
    throw InputError(
        fmt::format("--evaluations is {:g}; give a number of 1 or more", choice.most_evaluations));
  fit::FitProblem problem =
      fit::read_problem(fit::source_of(scene_file(choice.scene)), choice.overrides, choice.parameters);
  problem.data =
      fit::read_observations(choice.data, fit::source_of(scene_file(choice.scene)), choice.overrides);
  problem.coarse = choice.coarse;
  problem.most_evaluations = choice.most_evaluations;
  fit::check_problem(problem);
  return problem;
}

void run_fit(const FitChoice& choice, int& exit_status) {
  const fit::FitProblem problem = read_fit(choice);
  const std::string& name = problem.scene.name;
  const std::filesystem::path directory = choice.directory.empty()
                                              ? std::filesystem::path("out") / (name + "_fit")
                                              : std::filesystem::path(choice.directory);
  prepare_directory(directory);
  for (const std::string& warning : problem.scene.warnings) fmt::print(stderr, "mss: warning: {}\n", warning);
  const Json origin = provenance();
  fit::FitResult result;
  {
    TerminalProgress progress(name);
    result = fit::fit(problem, progress);
  }
  fit::write_fit(problem, result, origin, directory);
  fmt::print("{}see {}\n", fit::summary(problem, result), directory.string());
  std::fflush(stdout);
  for (const std::string& warning : fit::warnings_of(problem, result))
    fmt::print(stderr, "mss: {}: {}\n", name, warning);
  if (result.ended == fit::Ended::interrupted)
    exit_status = exit_interrupted;
  else if (result.ended != fit::Ended::converged)
    exit_status = exit_check_failed;
}

void add_fit(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand(
      "fit", "the numbers of a scene that make its runs fit what was measured, with confidence intervals");
  const auto choice = std::make_shared<FitChoice>();
  command->add_option("scene", choice->scene, "Scene file (TOML), or a name from `mss list scenes`")
      ->required();
  command
      ->add_option("--data", choice->data,
                   "What was measured: a TOML file of [[observation]], or a CSV file of a series with the "
                   "columns time and some of series.csv (experiments/fit/README.md)")
      ->required();
  command
      ->add_option("--parameters", choice->parameters,
                   "Numbers to find: KEY or KEY=LOW..HIGH, one or more, keys as --set takes them, as in "
                   "material.young=1e5..1e6 damping.viscosity. They start from the scene's values; positive "
                   "ones are fitted in the logarithm")
      ->required();
  command->add_option(
      "--coarse", choice->coarse,
      "Settings that make a cheap twin of every run, as in body.cells=[10,3,3] "
      "body.cell_size=0.01: it is fitted in place of the scene, and the scene is run for what "
      "the twin has less");
  command->add_option("--evaluations", choice->most_evaluations, "Most runs of all that was measured")
      ->capture_default_str();
  command->add_option("--out", choice->directory, "Directory for the results (default ./out/<scene>_fit)");
  add_settings(*command, choice->overrides);
  command->callback([choice, &exit_status] { run_fit(*choice, exit_status); });
}

}  // namespace

Command fit_command() { return add_fit; }

}  // namespace mss::cli
