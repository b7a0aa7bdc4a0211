// `mss advise`: the cheapest way to compute a scene with an error below a limit.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "experiments/advise/report.hpp"
#include "experiments/advise/static_advice.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/quantities.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/harness/other_work.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"

namespace mss::cli {

using namespace mss::advise;  // of which this is the command

namespace {

namespace fs = std::filesystem;

struct AdviseChoice {
  std::string scene;
  std::vector<std::string> overrides;
  std::string error;
  std::string of;
  std::string budget;
  std::string directory;
  std::optional<double> patience;
  std::optional<int> grid;
  bool unpruned = false;
};

constexpr const char* default_error = "1%";
constexpr const char* of_stability = "stability";
/// References say how accurate candidates are where an error is required, and else rank them.
constexpr double usual_patience = 60, patience_of_stability = 8;

ErrorOf read_error_of(const std::string& text) {
  std::vector<std::string> names = error_names();
  names.emplace_back(of_stability);
  const auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end())
    throw InputError(fmt::format("--of {} is unknown; {}give one of {}", text, question(text, names),
                                 fmt::join(names, ", ")));
  return ErrorOf(found - names.begin());
}

void check_stability(const AdviseChoice& choice) {
  if (choice.budget.empty())
    throw InputError("--of stability finds what fits a budget; give one, as in --budget 4ms/frame");
  if (!choice.error.empty())
    throw InputError(fmt::format(
        "--error {} is not required by --of stability, which says the error; leave it out", choice.error));
  if (choice.grid)
    throw InputError("--grid is about errors, and --of stability about a budget; leave one out");
}

AdviseRequest read_request(const AdviseChoice& choice) {
  AdviseRequest request{.error = read_share("--error", choice.error.empty() ? default_error : choice.error)};
  request.of_stability = choice.of == of_stability;
  request.patience = choice.patience.value_or(request.of_stability ? patience_of_stability : usual_patience);
  if (request.of_stability)
    check_stability(choice);
  else if (!choice.of.empty())
    request.of = read_error_of(choice.of);
  if (choice.unpruned && !choice.grid)
    throw InputError("--unpruned is about --grid, which is not given; give both, or neither");
  if (!choice.budget.empty()) request.budget = read_budget(choice.budget);
  if (!(request.patience > 0))
    throw InputError(fmt::format("--patience is {}; give a positive number of seconds", request.patience));
  constexpr int finest_grid = 96;
  if (choice.grid && (*choice.grid < 1 || *choice.grid > finest_grid))
    throw InputError(fmt::format("--grid is {}; give a number from 1 to {}", *choice.grid, finest_grid));
  return request;
}

void warn_about_sharing(const Scene& scene) {
  if (scene.body.sharing == Sharing::uniform)
    fmt::print(stderr,
               "mss: {}: body.sharing is \"uniform\", with which other cells are another material; advice is "
               "about the same springs shared as \"weighted\"\n",
               scene.name);
}

/// Where no terminal shows the progress.
void say_that_it_takes_time(const std::string& scene, const AdviseRequest& request) {
  if (isatty(STDERR_FILENO) == 1) return;
  fmt::print(
      stderr,
      "mss: advice for {} may take minutes: a reference up to the work of {:g} s of one core (--patience)\n",
      scene, request.patience);
}

/// Of work beside the advisor's. One thread's costs are of its own processor time, so that what is left are
/// shared caches and clock rates.
void say_what_disturbed(const std::string& scene, const OtherWorkWatch& others) {
  const std::optional<OtherWork> other = others.so_far();
  if (!other || other->share < disturbing_share) return;
  fmt::print(
      stderr,
      "mss: {}: other work took {:.0f} percent of the cores meanwhile: costs are of processor time where one "
      "thread works, but may be too high, those of more threads most; errors and --patience are not "
      "affected\n",
      scene, 100 * other->share);
}

fs::path directory_of(const AdviseChoice& choice, const Scene& scene) {
  return choice.directory.empty() ? fs::path("out") / (scene.name + "_advice") : fs::path(choice.directory);
}

void say_how_it_ended(const std::string& scene, bool stopped, const std::string& explanation,
                      int& exit_status) {
  if (stopped) {
    fmt::print(stderr, "mss: {} was interrupted; what was tried is kept\n", scene);
    exit_status = exit_interrupted;
  } else if (!explanation.empty()) {
    fmt::print(stderr, "mss: {}: {}\n", scene, explanation);
    exit_status = exit_check_failed;
  }
}

void advise_static_scene(const Scene& scene, const AdviseChoice& choice, const AdviseRequest& request,
                         const fs::path& directory, int& exit_status) {
  if (request.of_stability)
    throw InputError(
        fmt::format("--of stability is about motion, and {} is at rest (solve.integrator = \"{}\")",
                    scene.name, scene.solve.integrator));
  if (request.budget || choice.grid)
    throw InputError(fmt::format("--{} is about motion, and {} is at rest (solve.integrator = \"{}\")",
                                 choice.grid ? "grid" : "budget", scene.name, scene.solve.integrator));
  check_static(request);
  check_solve(scene);
  prepare_directory(directory);
  const Json origin = provenance();
  say_that_it_takes_time(scene.name, request);
  StaticAdvice advice;
  {
    TerminalProgress progress(scene.name);
    advice = advise_at_rest(scene, request, progress);
  }
  write_static_advice(scene, request, advice, origin, directory);
  fmt::print("{}see {}\n", summary(scene, request, advice), directory.string());
  say_how_it_ended(scene.name, advice.stopped, advice.explanation, exit_status);
}

/// Costs are the processor's, and most methods that are tried step on no device.
AdviseChoice on_processor(AdviseChoice choice) {
  const Scene scene = load_scene(scene_file(choice.scene), choice.overrides);
  if (scene.solve.device == SolveConfig{}.device) return choice;
  fmt::print(stderr, "mss: {}: what is advised is for the processor, not for solve.device = \"{}\"\n",
             scene.name, scene.solve.device);
  choice.overrides.emplace_back("solve.device=\"cpu\"");
  return choice;
}

void run_advise(const AdviseChoice& given, int& exit_status) {
  const AdviseChoice choice = on_processor(given);
  AdviseRequest request = read_request(choice);
  const Scene scene = load_scene(scene_file(choice.scene), choice.overrides);
  check_one_body(scene, "mss advise");
  if (!scene.body.is_solid())
    throw InputError(
        fmt::format("{}: mss advise chooses among cells of three dimensions, and body.cells make {}",
                    scene.file.string(), scene.body.noun()));
  if (is_static(scene))
    return advise_static_scene(scene, choice, request, directory_of(choice, scene), exit_status);
  SceneFamily family(scene_file(choice.scene), choice.overrides);
  if (choice.of.empty() && !request.of_stability) request.of = default_error_of(family.given());
  const std::string& name = family.given().name;
  const fs::path directory = directory_of(choice, family.given());
  prepare_directory(directory);
  warn_about_sharing(family.given());
  const Json origin = provenance();
  say_that_it_takes_time(name, request);
  Advice advice;
  const OtherWorkWatch others;
  {
    TerminalProgress progress(name);
    advice = request.of_stability ? advise_for_frames(family, request, progress)
             : choice.grid        ? try_all(family, request, *choice.grid, std::max(4, 2 * *choice.grid),
                                            !choice.unpruned, progress)
                                  : advise::advise(family, request, progress);
  }
  write_advice(family, request, advice, origin, directory);
  say_what_disturbed(name, others);
  fmt::print("{}", summary(family, request, advice));
  if (const fs::path advised = directory / (name + "_advised.toml"); fs::exists(advised))
    fmt::print("as a scene: {}\n", advised.string());
  fmt::print("see {}\n", directory.string());
  say_how_it_ended(name, advice.stopped, advice.explanation, exit_status);
}

void add_advise(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand(
      "advise", "the cheapest cells, springs, method and step for a scene with an error below a limit");
  const auto choice = std::make_shared<AdviseChoice>();
  command->add_option("scene", choice->scene, "Scene file (TOML), or a name from `mss list scenes`")
      ->required();
  command->add_option("--error", choice->error,
                      fmt::format("Largest error allowed, as in {0} (default {0})", default_error));
  command->add_option(
      "--of", choice->of,
      "Quantity whose error is meant: displacement (the default where anything is held), "
      "deformation (else), volume, frequency or energy; of a scene at rest displacement or energy. Or "
      "stability: of what fits --budget, stable and unfolded, the most accurate");
  command->add_option("--budget", choice->budget,
                      "Most time that a frame of 1/60 s may take, as in 16.7ms/frame");
  command->add_option(
      "--patience", choice->patience,
      fmt::format("Most work that one reference may take, counted in seconds of one core, however "
                  "busy it is (default {:g}, with --of stability {:g})",
                  usual_patience, patience_of_stability));
  command->add_option("--grid", choice->grid,
                      "Instead of searching, try everything in cells split up to N times the coarsest");
  command->add_flag("--unpruned", choice->unpruned,
                    "With --grid: run every candidate to its end, however wrong or slow it is");
  command->add_option("--out", choice->directory, "Directory for the results (default ./out/<scene>_advice)");
  add_settings(*command, choice->overrides);
  command->callback([choice, &exit_status] { run_advise(*choice, exit_status); });
}

}  // namespace

Command advise_command() { return add_advise; }

}  // namespace mss::cli
