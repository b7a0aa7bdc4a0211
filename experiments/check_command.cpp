// `mss check`: reruns what every experiment guards and compares it with the baselines in results/check.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "core/error.hpp"
#include "experiments/commands.hpp"
#include "experiments/experiment.hpp"
#include "experiments/output.hpp"
#include "experiments/process.hpp"
#include "experiments/provenance.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

struct CheckChoice {
  bool quick = false;
  std::string against;
  std::string directory = "out/check";
  bool promote = false;
  std::string why;
};

/// The root of the source tree that this program was built from.
fs::path source_tree() { return scenes_directory().parent_path().parent_path(); }

std::string table_name(const ExperimentInfo& info, bool quick) {
  return info.name + (quick ? "_quick.csv" : ".csv");
}

/// The guarded table of every experiment, written to a directory; false if interrupted.
bool rerun(const CheckChoice& choice) {
  for (const ExperimentInfo& info : experiments()) {
    std::string csv;
    {
      TerminalProgress progress("check " + info.name);
      csv = info.guard.table(choice.quick, progress).csv();
    }
    if (interrupted()) return false;
    write_atomically(fs::path(choice.directory) / table_name(info, choice.quick), csv);
  }
  return true;
}

/// Prints what moved and returns how much did.
std::size_t report_deviations(const CheckChoice& choice, const fs::path& baselines) {
  std::size_t total = 0, rows = 0;
  for (const ExperimentInfo& info : experiments()) {
    const std::string name = table_name(info, choice.quick);
    const std::string now = read_file(fs::path(choice.directory) / name);
    const std::vector<Deviation> moved = compare(read_file(baselines / name), now, info.guard);
    for (const Deviation& d : moved) fmt::print("{}: {}\n", name, to_string(d));
    total += moved.size();
    rows += std::size_t(std::max<std::ptrdiff_t>(std::count(now.begin(), now.end(), '\n') - 1, 0));
  }
  if (total == 0)
    fmt::print("{} tables, {} rows: nothing moved\n", experiments().size(), rows);
  else
    fmt::print("{} deviation{} from {}; what is now is in {}\n", total, total == 1 ? "" : "s",
               baselines.string(), choice.directory);
  return total;
}

/// Only what is committed can be a baseline: else nobody could say what made it.
void check_promotable(const CheckChoice& choice) {
  if (choice.why.empty())
    throw InputError("--promote needs --why \"the reason\", which is kept beside the baseline");
  if (choice.why.find('\n') != std::string::npos) throw InputError("--why has several lines; give one");
  const ProgramRun git =
      run_program({"git", "-C", source_tree().string(), "status", "--porcelain", "--untracked-files=no"});
  if (git.exit_status != 0) throw InputError("--promote needs the git repository that mss was built from");
  if (!git.output.empty() || provenance()["modified"] == true)
    throw InputError("--promote refuses a modified tree: commit what changed, build, and promote then");
}

/// What is now becomes the baseline, and why is kept.
void promote(const CheckChoice& choice, const fs::path& baselines) {
  const Json where = provenance();
  const fs::path log = baselines / "promotions.csv";
  std::string lines = fs::exists(log) ? read_file(log) : "date,commit,tables,why\n";
  std::string why = choice.why;
  for (std::size_t at = 0; (at = why.find('"', at)) != std::string::npos; at += 2) why.insert(at, 1, '"');
  lines += fmt::format("{},{},{},\"{}\"\n", where["date"].get<std::string>(),
                       where["commit"].get<std::string>(), choice.quick ? "quick" : "full", why);
  for (const ExperimentInfo& info : experiments()) {
    const std::string name = table_name(info, choice.quick);
    write_atomically(baselines / name, read_file(fs::path(choice.directory) / name));
  }
  write_atomically(log, lines);
  const fs::path meta = baselines / "meta.json";
  Json sources = fs::exists(meta) ? Json::parse(read_file(meta)) : Json::object();
  sources[choice.quick ? "quick" : "full"] = {{"why", choice.why}, {"provenance", where}};
  write_atomically(meta, sources.dump(2) + "\n");
  fmt::print("{} tables are the baseline now, in {}\n", experiments().size(), baselines.string());
}

void run_check(const CheckChoice& choice, int& exit_status) {
  const fs::path baselines =
      choice.against.empty() ? source_tree() / "results" / "check" : fs::path(choice.against);
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

void add(CLI::App& app, int& exit_status) {
  CLI::App* command =
      app.add_subcommand("check", "rerun what the baselines guard and name every row that moved");
  const auto choice = std::make_shared<CheckChoice>();
  command->add_flag("--quick", choice->quick, "The small tables only: under two minutes");
  command->add_option("--against", choice->against,
                      "Directory of baselines (default: results/check of the source tree)");
  command->add_option("--out", choice->directory, "Directory for the tables as they are now")
      ->capture_default_str();
  command->add_flag("--promote", choice->promote, "Make what is now the baseline; needs --why");
  command->add_option("--why", choice->why, "Why the baseline may change, in a line");
  command->callback([choice, &exit_status] { run_check(*choice, exit_status); });
}

}  // namespace

Command check_command() { return add; }

}  // namespace mss
