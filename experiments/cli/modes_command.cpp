// `mss modes`: vibrations of a scene's body about rest, or about where it comes to rest under what acts on
// it, and the step that they allow.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <memory>
#include <numbers>

#include "core/base/error.hpp"
#include "core/scene/scene_writer.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/reduced_model.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::cli {

namespace {

namespace fs = std::filesystem;
constexpr double turn = 2 * std::numbers::pi;

struct ModesChoice {
  std::string scene;
  std::string directory;
  std::vector<std::string> overrides;
  int count = 10;
  std::string about = "rest";
};

Table modes_table(const std::vector<Mode>& modes) {
  Table table({{"mode"}, {"omega", "rad/s"}, {"frequency", "Hz"}});
  for (std::size_t i = 0; i < modes.size(); ++i)
    table.add({std::int64_t(i + 1), modes[i].omega, modes[i].omega / turn});
  return table;
}

/// A method without a limit has no largest step.
Json step_or_null(double dt) { return std::isfinite(dt) ? Json(dt) : Json(nullptr); }

Json summary(const Scene& scene, const std::string& about, double omega_max, double bound, double crushed,
             double limit, const Table& table, double error) {
  Json steps = Json::object();
  for (const IntegratorInfo& method : integrators())
    if (method.stepping == Stepping::fixed && method.limit) {
      try {
        steps[method.name] = safe_share * stable_step(method, {.omega = bound});
      } catch (const InputError&) {
        steps[method.name] = nullptr;  // no step is safe
      }
    }
  return {{"scene", scene.name},
          {"model", scene.model},
          {"about", about},
          {"modes", table.size()},
          {"omega_error", error},
          {"omega_max", omega_max},
          {"omega_bound", bound},
          {"omega_bound_crushed", crushed},
          {"safe_dt_undamped", steps},
          {"integrator", scene.solve.integrator},
          {"limit_dt", step_or_null(limit)},
          {"configuration", to_json(scene)},
          {"provenance", provenance()}};
}

/// What `mss run` says: the step that the bound is sure of, and what local steps make of it.
std::string sure_step(const Scene& scene, const IntegratorInfo& method, const SolidSystem<double>& system) {
  std::string text = fmt::format("sure to be up to {:.6g} s, by the bound",
                                 guaranteed_step(method, system.spectral_bound()));
  if (scene.solve.local_steps)
    text += fmt::format("; in local steps {:.6g} s", guaranteed_step(method, system.local_bound()));
  return text;
}

/// The stable step where the fold guard acts, beside the one of dt = "safe", for methods that have one.
void print_with_guard(const IntegratorInfo& method, const SpectralBound& bound, double crushed) {
  fmt::print("  where the fold guard acts: at most {:.6g} rad/s", crushed);
  if (method.stepping == Stepping::fixed && method.limit)
    if (const double safe = guaranteed_step(method, bound); safe > 0) {
      const double there = guaranteed_step(method, {.omega = crushed, .damping = bound.damping});
      fmt::print("; use dt = {:.6g} s there, {:.3g} of the safe one", safe_share * there, there / safe);
    }
  fmt::print("\n");
}

/// That none is missing, and how exact they are.
void print_completeness(const Modes& slow, int asked) {
  if (int(slow.modes.size()) < asked)
    fmt::print("  these are all: {} modes were asked for, and a body has as many as unknowns, {}\n", asked,
               slow.modes.size());
  else
    fmt::print("  no other is slower, by a search among motions orthogonal to these\n");
  fmt::print("  each frequency is right to {:.1g} of it, by its residual\n", slow.error);
}

/// The body as nothing acts on it, or as it comes to rest at the scene's end under its holds, loads and
/// gravity.
Status find_state(const ModesChoice& choice, const Scene& scene, SolidSystem<double>& system,
                  State<double>& state) {
  state = system.undeformed_state();
  if (choice.about == "rest") return Status::ok;
  if (!scene.environment.planes.empty() || !scene.environment.obstacles.empty())
    throw InputError(
        fmt::format("{}: --about equilibrium is of bodies that touch nothing, and the scene has planes or "
                    "obstacles; leave out one of them",
                    scene.file.string()));
  Work work;
  return find_integrator("static")
      .make<double>({.length_scale = system.cell_size()})
      ->advance(system, state, scene.solve.duration, work);
}

void report_failure(const Scene& scene, const std::string& what, Status status, int& exit_status) {
  fmt::print(stderr, "mss: {}: {} found: {}\n", scene.name, what, to_string(status));
  exit_status = exit_simulation_failed;
}

/// A sheet or a rope without tension resists nothing across it.
void warn_of_slack(const Scene& scene, const ModesChoice& choice) {
  if (scene.body.is_solid() || choice.about != "rest") return;
  fmt::print(
      stderr,
      "mss: warning: {} at rest has no tension and resists nothing across it; with --about equilibrium "
      "its vibrations are those under holds, loads and gravity\n",
      scene.body.noun());
}

void run_modes(const ModesChoice& choice, int& exit_status) {
  constexpr int most = 200;
  if (choice.count < 1 || choice.count > most)
    throw InputError(fmt::format("--count is {}; give a number of modes from 1 to {}", choice.count, most));
  const MatchedScene ready = load_matched_scene(scene_file(choice.scene), choice.overrides);
  const Scene& scene = ready.scene;
  check_model(scene);
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  const fs::path directory =
      choice.directory.empty() ? fs::path("out") / (scene.name + "_modes") : fs::path(choice.directory);
  const Body body(scene.body);
  const std::unique_ptr<const RefinedBody> refined = refined_body_of(scene);
  const OtherBodies others = other_bodies(scene);
  const auto system = make_solid<double>(unreduced(scene), body, refined.get(), others);
  if (unknowns_of(*system).empty())
    throw InputError(fmt::format("{}: everything is held, so nothing can vibrate", scene.file.string()));
  prepare_directory(directory);
  std::signal(SIGINT, SIG_DFL);  // files are written at the end: nothing is lost by ending at once
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "mss: warning: {}\n", warning);

  warn_of_slack(scene, choice);
  State<double> rest;
  if (const Status status = find_state(choice, scene, *system, rest); status != Status::ok)
    return report_failure(scene, "no equilibrium was", status, exit_status);
  Work work;
  const Modes slow = slowest_modes(*system, rest, choice.count, work);
  if (system->memory()) system->memory()->come_to(rest);  // steps meet springs as stiff as they are at once
  const Modes fast = fastest_mode(*system, rest, work);
  const PredictedStep limit = predicted_step(method, *system, rest, work);
  for (const Status status : {slow.status, fast.status, limit.status})
    if (status != Status::ok)
      return report_failure(scene, fmt::format("the vibrations about {} were not", choice.about), status,
                            exit_status);
  const Table table = modes_table(slow.modes);
  const double omega_max = fast.modes.front().omega, bound = system->spectral_bound().omega,
               crushed = with_guard(system->spectral_bound(), system->levels()).omega;
  write_atomically(directory / "modes.csv", table.csv());
  write_atomically(
      directory / "summary.json",
      summary(scene, choice.about, omega_max, bound, crushed, limit.dt, table, slow.error).dump(2) + "\n");

  if (ready.report)
    for (const std::string& line : description(*ready.report)) fmt::print("{}: {}\n", scene.name, line);
  fmt::print("{}: vibrations about {}, {} model, {} unknowns\n", scene.name, choice.about, scene.model,
             unknowns_of(*system).size());
  const char* unresisted = scene.body.is_solid() ? "  (moves as a whole)" : "  (nothing resists it)";
  for (std::size_t i = 0; i < slow.modes.size(); ++i)
    fmt::print("  {:>4}  {:>12.6g} Hz  {:>12.6g} rad/s{}\n", i + 1, slow.modes[i].omega / turn,
               slow.modes[i].omega, slow.modes[i].omega == 0 ? unresisted : "");
  print_completeness(slow, choice.count);
  if (system->memory()) fmt::print("  of springs that have relaxed; the next line is of springs at once\n");
  fmt::print("   max  {:>12.6g} Hz  {:>12.6g} rad/s; the bound of dt = \"safe\": {:.6g} rad/s\n",
             omega_max / turn, omega_max, bound);
  if (std::isfinite(limit.dt))
    fmt::print("  with {} small motions are stable up to dt = {:.6g} s, as found; {}\n", method.name,
               limit.dt, sure_step(scene, method, *system));
  if (crushed > bound) print_with_guard(method, system->spectral_bound(), crushed);
  fmt::print("see {}\n", directory.string());
}

void add_modes(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand("modes",
                                         "vibrations of a scene about rest, or about its equilibrium; writes "
                                         "modes.csv, summary.json");
  const auto choice = std::make_shared<ModesChoice>();
  command->add_option("scene", choice->scene, "Scene file (TOML), or a name from `mss list scenes`")
      ->required();
  command->add_option("--count", choice->count, "Number of modes, the slowest first")->capture_default_str();
  command
      ->add_option("--about", choice->about,
                   "Rest, as nothing acts on the body, or the equilibrium of its holds, loads and gravity")
      ->check(CLI::IsMember({"rest", "equilibrium"}))
      ->capture_default_str();
  command->add_option("--out", choice->directory, "Directory for the results (default ./out/<scene>_modes)");
  add_settings(*command, choice->overrides);
  command->callback([choice, &exit_status] { run_modes(*choice, exit_status); });
}

}  // namespace

Command modes_command() { return add_modes; }

}  // namespace mss::cli
