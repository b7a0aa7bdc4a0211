// `mss check`: reruns a small table of every experiment and compares it with its baseline in results/check,
// or simulates scenes and compares their ends with their [expect].
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/limits.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/installation.hpp"
#include "experiments/io/output.hpp"
#include "experiments/io/process.hpp"
#include "experiments/simulation/diagnostics.hpp"
#include "experiments/simulation/expectation.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"

namespace mss::cli {

namespace {

namespace fs = std::filesystem;

constexpr int default_threads = 1;  // results do not depend on them, and small bodies are fastest with one

struct CheckChoice {
  std::vector<std::string> scenes;
  std::vector<std::string> overrides;
  std::string results;
  bool quick = false;
  std::vector<std::string> only;  ///< names of experiments; empty: all
  std::optional<int> threads;
  std::string against;
  std::string directory;  ///< empty: not given
  bool promote = false;
  std::string why;
};

std::string table_name(const ExperimentInfo& info, bool quick) {
  return info.name + (quick ? "_quick.csv" : ".csv");
}

/// The experiments to check. Throws InputError for an unknown name.
std::vector<ExperimentInfo> chosen(const CheckChoice& choice) {
  if (choice.only.empty()) return experiments();
  std::vector<ExperimentInfo> infos;
  for (const std::string& name : choice.only) infos.push_back(find_experiment(name));
  return infos;
}

/// What the user will wait for.
void announce(std::size_t tables, bool quick) {
  fmt::print(stderr, "mss: computes {} table{} to compare with baselines; {}\n", tables,
             tables == 1 ? "" : "s",
             quick ? "takes less than a minute" : "may take minutes, with --quick less than one");
}

/// The checked table of every experiment, written to a directory; false if interrupted.
bool rerun(const CheckChoice& choice) {
  const std::vector<ExperimentInfo> infos = chosen(choice);
  announce(infos.size(), choice.quick);
  for (const ExperimentInfo& info : infos) {
    std::string csv;
    {
      TerminalProgress progress("check " + info.name);
      csv = info.baseline
                .table({.quick = choice.quick, .threads = choice.threads.value_or(default_threads)}, progress)
                .csv();
    }
    if (interrupted()) return false;
    write_atomically(fs::path(choice.directory) / table_name(info, choice.quick), csv);
  }
  return true;
}

/// The truths in the directory of the baselines. It may have none if it is the user's own.
std::vector<Truth> truths_of(const CheckChoice& choice, const fs::path& baselines) {
  const fs::path file = baselines / "truth.csv";
  if (!choice.against.empty() && !fs::exists(file)) return {};
  std::vector<Truth> truths = read_truths(file);
  for (const Truth& truth : truths) {
    std::vector<std::string> tables;
    for (const ExperimentInfo& info : experiments())
      for (const bool quick : {false, true})
        tables.push_back(fs::path(table_name(info, quick)).stem().string());
    if (std::find(tables.begin(), tables.end(), truth.table) == tables.end())
      throw InputError(fmt::format("{}: there is no table '{}'; {}give one of {}", file.string(), truth.table,
                                   question(truth.table, tables), fmt::join(tables, ", ")));
  }
  return truths;
}

/// Prints every deviation from baselines and truths, and returns their number.
std::size_t report_deviations(const CheckChoice& choice, const fs::path& baselines) {
  const std::vector<Truth> truths = truths_of(choice, baselines);
  std::size_t total = 0, rows = 0, compared = 0;
  const std::vector<ExperimentInfo> infos = chosen(choice);
  for (const ExperimentInfo& info : infos) {
    const std::string name = table_name(info, choice.quick);
    const std::string now = read_file(fs::path(choice.directory) / name);
    const std::string table = fs::path(name).stem().string();
    const auto moved = compare(read_file(baselines / name), now, info.baseline);
    const auto wrong = compare_with_truths(truths, table, now, info.baseline);
    for (const Deviation& d : moved) fmt::print("{}: {}\n", name, to_string(d));
    for (const Deviation& d : wrong) fmt::print("{}: {}\n", name, to_string(d, "should be"));
    total += moved.size() + wrong.size();
    compared += std::size_t(
        std::count_if(truths.begin(), truths.end(), [&](const Truth& t) { return t.table == table; }));
    rows += std::size_t(std::max<std::ptrdiff_t>(std::count(now.begin(), now.end(), '\n') - 1, 0));
  }
  if (total == 0)
    fmt::print("{} table{}, {} rows: nothing moved, and {} truths are met\n", infos.size(),
               infos.size() == 1 ? "" : "s", rows, compared);
  else
    fmt::print("{} deviation{} from {}; the present tables are in {}\n", total, total == 1 ? "" : "s",
               baselines.string(), choice.directory);
  return total;
}

/// A baseline must come from committed sources: else its origin would be unknown.
void check_promotable(const CheckChoice& choice) {
  if (choice.why.empty())
    throw InputError("--promote needs --why \"the reason\", which is recorded with the baseline");
  if (choice.why.find('\n') != std::string::npos) throw InputError("--why has several lines; give one");
  const ProgramRun git =
      run_program({"git", "-C", shipped_files().string(), "status", "--porcelain", "--untracked-files=no"});
  if (git.exit_status != 0) throw InputError("--promote needs the git repository that mss was built from");
  if (!git.output.empty() || provenance()["modified"] == true)
    throw InputError("--promote refuses a modified tree: commit what changed, build, and promote then");
}

/// Makes the present tables the baseline and records the reason.
void promote(const CheckChoice& choice, const fs::path& baselines) {
  const Json where = provenance();
  const fs::path log = baselines / "promotions.csv";
  std::string lines = fs::exists(log) ? read_file(log) : "date,commit,tables,why\n";
  std::string why = choice.why;
  for (std::size_t at = 0; (at = why.find('"', at)) != std::string::npos; at += 2) why.insert(at, 1, '"');
  lines +=
      fmt::format("{},{},{},\"{}\"\n", where["date"].get<std::string>(), where["commit"].get<std::string>(),
                  (choice.quick ? "quick" : "full") +
                      (choice.only.empty() ? "" : fmt::format(" {}", fmt::join(choice.only, " "))),
                  why);
  const std::vector<ExperimentInfo> infos = chosen(choice);
  for (const ExperimentInfo& info : infos) {
    const std::string name = table_name(info, choice.quick);
    write_atomically(baselines / name, read_file(fs::path(choice.directory) / name));
  }
  write_atomically(log, lines);
  if (!choice.only.empty()) {  // meta.json is about all of them
    fmt::print("{} tables are the new baseline, in {}\n", infos.size(), baselines.string());
    return;
  }
  const fs::path meta = baselines / "meta.json";
  Json sources = fs::exists(meta) ? Json::parse(read_file(meta)) : Json::object();
  sources[choice.quick ? "quick" : "full"] = {{"why", choice.why}, {"provenance", where}};
  write_atomically(meta, sources.dump(2) + "\n");
  fmt::print("{} tables are the new baseline, in {}\n", infos.size(), baselines.string());
}

/// The scene files given, and those in the directories given that have an [expect].
std::vector<Scene> scenes_to_judge(const CheckChoice& choice) {
  std::vector<Scene> scenes;
  for (const std::string& name : choice.scenes) {
    if (!fs::is_directory(name)) {
      scenes.push_back(load_matched_scene(scene_file(name), choice.overrides).scene);
      if (scenes.back().expectations.empty())
        throw InputError(fmt::format("{} has no table [expect]; add one", scenes.back().file.string()));
      continue;
    }
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(name))
      if (entry.path().extension() == ".toml") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    const std::size_t before = scenes.size();
    for (const fs::path& file : files)
      if (Scene scene = load_matched_scene(file, choice.overrides).scene; !scene.expectations.empty())
        scenes.push_back(std::move(scene));
    if (scenes.size() == before)
      throw InputError(fmt::format("{} has no scene (TOML) with a table [expect]", name));
  }
  for (const Scene& scene : scenes) {
    check_solve(scene);
    check_expected_boxes(scene);
  }
  return scenes;
}

SceneEnd simulated(Scene scene, int threads) {
  scene.solve.threads = threads;
  SimulationResult result;
  {
    TerminalProgress progress("check " + scene.name);
    result = simulate(scene, progress);
  }
  for (const std::string& diagnostic : diagnostics_of(scene, result))
    fmt::print(stderr, "mss: {}: {}\n", scene.name, diagnostic);
  return scene_end_of(result);
}

void check_scenes(const CheckChoice& choice, int& exit_status) {
  const std::vector<Scene> scenes = scenes_to_judge(choice);
  if (!choice.results.empty() && scenes.size() != 1)
    throw InputError(fmt::format("--results are of one scene, and {} are given", scenes.size()));
  std::size_t expectations = 0, total = 0;
  for (const Scene& scene : scenes) {
    const SceneEnd end = choice.results.empty() ? simulated(scene, choice.threads.value_or(default_threads))
                                                : read_scene_end(scene, choice.results);
    if (interrupted()) {
      exit_status = exit_interrupted;
      return;
    }
    if (!choice.results.empty())
      for (const std::string& doubt : doubts_about(scene, end))
        fmt::print(stderr, "mss: warning: {}: {}\n", choice.results, doubt);
    const std::vector<Deviation> wrong = compare_with_expectations(scene, end);
    for (const Deviation& d : wrong) fmt::print("{}\n", to_string(d, "should be"));
    expectations += scene.expectations.size();
    total += wrong.size();
  }
  fmt::print("{} scene{}, {} expectation{}: {}\n", scenes.size(), scenes.size() == 1 ? "" : "s", expectations,
             expectations == 1 ? "" : "s",
             total == 0 ? "all met" : fmt::format("{} deviation{}", total, total == 1 ? "" : "s"));
  if (total > 0) exit_status = exit_check_failed;
}

void check_usage(const CheckChoice& choice) {
  if (choice.scenes.empty() && !choice.overrides.empty())
    throw InputError("--set changes a scene, and none is given");
  if (choice.scenes.empty() && !choice.results.empty())
    throw InputError("--results needs the scene whose [expect] applies to them");
  if (!choice.scenes.empty() &&
      (choice.quick || choice.promote || !choice.against.empty() || !choice.only.empty()))
    throw InputError(
        "scenes are compared with their own [expect]: --quick, --only, --against and --promote do not apply "
        "to them");
  if (!choice.scenes.empty() && !choice.directory.empty())
    throw InputError("checking scenes writes no files: --out does not apply to them");
  if (!choice.results.empty() && choice.threads)
    throw InputError("--results are not computed anew: --threads does not apply to them");
  if (!choice.why.empty() && !choice.promote)
    throw InputError("--why is the reason for --promote, which is missing");
}

void run_check(CheckChoice choice, int& exit_status) {
  check_usage(choice);
  if (choice.directory.empty()) choice.directory = "out/check";
  if (!choice.scenes.empty()) {
    check_scenes(choice, exit_status);
    return;
  }
  const fs::path baselines =
      choice.against.empty() ? shipped_files() / "results" / "check" : fs::path(choice.against);
  if (choice.promote) check_promotable(choice);
  if (!choice.promote && !fs::is_directory(baselines))
    throw InputError(
        fmt::format("{} is no directory of baselines; give one with --against", baselines.string()));
  prepare_directory(choice.directory);
  if (!rerun(choice)) {
    fmt::print(stderr, "mss: check was interrupted; nothing was compared\n");
    exit_status = exit_interrupted;
    return;
  }
  if (choice.promote)
    promote(choice, baselines);
  else if (report_deviations(choice, baselines) > 0)
    exit_status = exit_check_failed;
}

void add_check(CLI::App& app, int& exit_status) {
  CLI::App* command =
      app.add_subcommand("check", "rerun the tables that have a baseline and list every row that moved");
  const auto choice = std::make_shared<CheckChoice>();
  command->add_option("scenes", choice->scenes,
                      "Scenes with a table [expect], or directories of such: simulated and compared with it, "
                      "instead of all tables");
  command->add_option(
      "--results", choice->results,
      "Compare the results in this directory (summary.json, series.csv, particles.csv; their format: "
      "experiments/peer/README.md) with the scene's [expect] instead of simulating it");
  constexpr int most_threads = 1024;
  command
      ->add_option("--threads", choice->threads,
                   "Threads of the core (default 1); results do not depend on them, and small bodies are "
                   "fastest with one")
      ->check(whole_number(1, most_threads));
  add_settings(*command, choice->overrides);
  command->add_flag("--quick", choice->quick,
                    "The small tables only: less than a minute, instead of minutes");
  command->add_option("--only", choice->only, "These studies only, by name")->delimiter(',');
  command->add_option("--against", choice->against,
                      "Directory of baselines (default: those that come with the program)");
  command->add_option("--out", choice->directory, "Directory for the present tables (default out/check)");
  command->add_flag("--promote", choice->promote, "Make the present tables the baseline; needs --why");
  command->add_option("--why", choice->why, "Reason for the new baseline, in one line");
  command->callback([choice, &exit_status] { run_check(*choice, exit_status); });
}

}  // namespace

Command check_command() { return add_check; }

}  // namespace mss::cli
