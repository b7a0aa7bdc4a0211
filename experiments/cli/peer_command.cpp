// `mss peer export`: a scene and its true motion as tables for other programs; `mss peer score`: what their
// results are worth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "core/base/error.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/quantities.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "experiments/peer/report.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/moving_body.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"

namespace mss::cli {

namespace {

struct ExportChoice {
  std::string scene;
  std::vector<std::string> overrides;
  double spacing = peer::default_spacing;
  std::string directory;
};

void run_export(const ExportChoice& choice, int& exit_status) {
  const Scene scene = load_matched_scene(scene_file(choice.scene), choice.overrides).scene;
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "mss: warning: {}\n", warning);
  check_one_body(scene, "mss peer export");
  const std::string directory = choice.directory.empty() ? "out/" + scene.name + "_export" : choice.directory;
  peer::Exchange exchange = peer::make_exchange(scene, choice.spacing);
  {
    TerminalProgress progress("export " + scene.name);
    peer::add_reference(exchange, progress);
  }
  if (interrupted()) {
    exit_status = exit_interrupted;
    return;
  }
  peer::write_export(exchange, directory);
  fmt::print(
      "{}: {} particles at {} times; reference: {}, dt = {:.4g} s, {:.2g} from one of twice the step; see "
      "{}\n",
      scene.name, exchange.body->particle_count(), exchange.times.size(), exchange.facts.integrator,
      exchange.facts.dt, exchange.facts.uncertainty, directory);
}

void add_export(CLI::App& peer, int& exit_status) {
  CLI::App* command = peer.add_subcommand(
      "export",
      "a scene as tables (particles, springs, cells, planes) and its true motion, for other programs");
  const auto choice = std::make_shared<ExportChoice>();
  command->add_option("scene", choice->scene, "Scene file (TOML), or a name from `mss list scenes`")
      ->required();
  command->add_option("--every", choice->spacing, "Time between samples [s] (default 1/60)");
  command->add_option("--out", choice->directory, "Folder to write to (default ./out/<scene>_export)");
  add_settings(*command, choice->overrides);
  command->callback([choice, &exit_status] { run_export(*choice, exit_status); });
}

struct ScoreChoice {
  std::vector<std::string> results;
  std::string scene;
  std::string error, volume, momentum, spin, energy, penetration, budget;
  std::string json, junit;
  std::string directory;
};

peer::Limits read_limits(const ScoreChoice& choice) {
  peer::Limits limits;
  const auto share = [](const char* option, const std::string& text, std::optional<double>& limit) {
    if (!text.empty()) limit = read_share(option, text);
  };
  share("--error", choice.error, limits.error);
  share("--volume", choice.volume, limits.volume);
  share("--momentum", choice.momentum, limits.momentum);
  share("--spin", choice.spin, limits.spin);
  share("--energy", choice.energy, limits.energy);
  if (!choice.penetration.empty()) limits.penetration = read_length("--penetration", choice.penetration);
  if (!choice.budget.empty()) limits.cpu_ms = 1e3 * mss::frame * read_budget(choice.budget);
  return limits;
}

/// A limit that the reference itself may miss.
void warn_about_reference(const peer::Limits& limits, const peer::ReferenceFacts& facts) {
  if (limits.error && facts.uncertainty > *limits.error / 4)
    fmt::print(
        stderr,
        "mss: warning: the reference is known to {:.2g} of the largest displacement only, and --error is "
        "{:g}\n",
        facts.uncertainty, *limits.error);
}

/// Results have the names of their folders, or where two have one name the paths that the user gave.
void tell_apart(const std::vector<std::string>& directories, std::vector<peer::Judged>& results) {
  std::vector<std::string> names;
  names.reserve(results.size());
  for (const peer::Judged& judged : results) names.push_back(judged.result.name);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::count(names.begin(), names.end(), names[i]) > 1) results[i].result.name = directories[i];
}

void run_score(const ScoreChoice& choice, int& exit_status) {
  const peer::Limits limits = read_limits(choice);
  const peer::Exchange exchange = peer::read_export(choice.scene);
  const peer::Judge judge(exchange);
  check_limits(limits, judge);
  warn_about_reference(limits, exchange.facts);
  std::vector<peer::Judged> results;
  for (const std::string& directory : choice.results)
    results.push_back(judged(judge, peer::read_result(directory, exchange), limits));
  tell_apart(choice.results, results);
  const Json origin = provenance();
  const std::string directory =
      choice.directory.empty() ? "out/" + exchange.scene.name + "_scores" : choice.directory;
  prepare_directory(directory);
  const DirectoryClaim claim(directory);
  const std::string no_chart = write_scores(judge, results, limits, origin, directory);
  if (!no_chart.empty()) fmt::print(stderr, "mss: there is no chart: {}\n", no_chart);
  if (!choice.json.empty())
    write_atomically(choice.json, to_json(judge, results, limits, origin).dump(2) + "\n");
  if (!choice.junit.empty()) write_atomically(choice.junit, to_junit(judge, results));
  fmt::print("{}see {}\n", summary(judge, results), directory);
  for (const peer::Judged& judged : results)
    if (is_missed(judged.checks)) exit_status = exit_check_failed;
}

void add_score(CLI::App& peer, int& exit_status) {
  CLI::App* command = peer.add_subcommand(
      "score",
      "what results of other programs are worth: error, volume, momentum, spin, penetration, energy, "
      "cost; exit status 1 if one misses a limit, or the scene's [expect]");
  const auto choice = std::make_shared<ScoreChoice>();
  command->add_option("results", choice->results, "Folders with samples.csv and cost.json, one a run")
      ->required();
  command->add_option("--scene", choice->scene, "The folder that `mss peer export` wrote")->required();
  command->add_option("--error", choice->error,
                      "Most root mean square distance from the reference, of its largest displacement: 5%");
  command->add_option("--volume", choice->volume, "Most distance from the reference's volume: 1%");
  command->add_option("--momentum", choice->momentum, "Most momentum that a free body may win or lose: 1%");
  command->add_option("--spin", choice->spin, "Most angular momentum that it may win or lose: 1%");
  command->add_option("--energy", choice->energy, "Most distance from the reference's energy: 5%");
  command->add_option("--penetration", choice->penetration, "How deep planes may be passed: 1mm");
  command->add_option("--budget", choice->budget, "Most processor time: 4ms/frame");
  command->add_option("--json", choice->json, "A file for verdict and scores as JSON");
  command->add_option("--junit", choice->junit, "A file for the checks as JUnit's XML");
  command->add_option("--out", choice->directory,
                      "Directory for tables and chart (default ./out/<scene>_scores)");
  command->callback([choice, &exit_status] { run_score(*choice, exit_status); });
}

void add_peer(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand(
      "peer", "scenes for other programs, and scores of what they made of them (experiments/peer/README.md)");
  command->require_subcommand(0, 1);
  add_export(*command, exit_status);
  add_score(*command, exit_status);
  command->callback([command] {
    if (command->get_subcommands().empty())
      throw InputError("give `mss peer export` or `mss peer score`; `mss peer --help` describes them");
  });
}

}  // namespace

Command peer_command() { return add_peer; }

}  // namespace mss::cli
