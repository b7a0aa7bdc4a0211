// `mss peer export`: a scene and its true motion as tables for other programs; `mss peer score`: what their
// results are worth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "core/base/error.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/peer/exchange.hpp"
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
  const Scene scene = load_scene(scene_file(choice.scene), choice.overrides);
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "mss: warning: {}\n", warning);
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

void add_peer(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand(
      "peer", "scenes for other programs, and scores of what they made of them (experiments/peer/README.md)");
  command->require_subcommand(1);
  add_export(*command, exit_status);
}

}  // namespace

Command peer_command() { return add_peer; }

}  // namespace mss::cli
