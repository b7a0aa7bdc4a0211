// `mss timing` and the like: one command per registered experiment; `mss reproduce` runs all of them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <memory>

#include "core/base/error.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/conclude.hpp"
#include "experiments/cli/limits.hpp"
#include "experiments/cli/number_list.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/harness/other_work.hpp"
#include "experiments/harness/page.hpp"
#include "experiments/harness/parts.hpp"
#include "experiments/harness/report.hpp"
#include "experiments/harness/study_times.hpp"
#include "experiments/io/output.hpp"
#include "experiments/plot/gnuplot.hpp"
#include "experiments/simulation/model.hpp"

namespace mss::cli {

namespace {

namespace fs = std::filesystem;

/// Options of one command, as given.
struct StudyChoice {
  ExperimentOptions options;
  std::string cells;
  std::string directory;
  std::string part;
};

constexpr int most_parallel = 1024;                            // threads or processes
constexpr std::int64_t largest_seed = std::int64_t(1) << 53U;  // exact in meta.json

void add_options(CLI::App& command, StudyChoice& choice, const std::vector<std::string>& studies,
                 const ExperimentAccepts& accepts) {
  command.add_flag("--quick", choice.options.quick,
                   "Smaller and fewer samples" + StudyClock(studies, true).comparison());
  command.add_option("--out", choice.directory, "Directory for the results")->capture_default_str();
  if (accepts.cells)
    command.add_option(
        "--cells", choice.cells,
        fmt::format("Cells per edge, up to {}: numbers and ranges, as in 2:4,8", accepts.largest_cells));
  if (accepts.integrators)
    command
        .add_option("--integrators", choice.options.integrators,
                    "Names from `mss list integrators`, as in rk4,cvode_bdf,vbd:5 (five iterations a step); "
                    "all if left "
                    "out")
        ->delimiter(',');
  if (accepts.scenes)
    command
        .add_option("--scenes", choice.options.scenes,
                    fmt::format("Some of {}", fmt::join(accepts.scenes(), ", ")))
        ->delimiter(',');
  if (accepts.model)
    command
        .add_option("--model", choice.options.model,
                    "Material model of the bodies: a name from `mss list models`")
        ->capture_default_str();
  if (accepts.threads)
    command
        .add_option("--threads", choice.options.threads,
                    "Largest number of threads of the sweep and the plain loop; 0: all cores")
        ->check(whole_number(1, most_parallel, "all cores"))
        ->capture_default_str();
  if (accepts.peers)
    command.add_flag("--peers", choice.options.peers,
                     "Time other programs' soft bodies too, where they are installed: Bullet's");
  if (accepts.devices)
    command
        .add_flag(
            "--devices", choice.options.devices,
            "Time nothing but steps on devices (`mss list devices`), beside the processor's: every card, "
            "or else the device in software")
        ->excludes("--peers");
  if (accepts.seed)
    command.add_option("--seed", choice.options.seed, "Seed of the random numbers")
        ->check(whole_number(0, largest_seed))
        ->capture_default_str();
  if (accepts.settings) add_settings(command, choice.options.settings);
  if (accepts.processes)
    command
        .add_option("--processes", choice.options.processes,
                    "Number of parallel processes; 0: all cores (`regimes`: one). Only times, and what "
                    "is concluded from times, depend on it")
        ->check(whole_number(1, most_parallel, "all cores"))
        ->capture_default_str();
  if (accepts.processes)
    command.add_option(
        "--part", choice.part,
        "Compute the i-th of N parts of the cases, as in 2/5; `mss merge` puts parts together");
}

}  // namespace

int conclude(const Report& report) {
  fmt::print("{}", report.summary);
  for (const fs::path& file : report.files) fmt::print("wrote {}\n", file.string());
  std::fflush(stdout);  // before what stderr says, where both go to one file
  if (!report.chart_problem.empty()) fmt::print(stderr, "mss: {}; the rows are kept\n", report.chart_problem);
  if (report.status == Status::interrupted) {
    fmt::print(stderr, "mss: {} was interrupted; finished rows are kept{}\n", report.name,
               report.resumable ? ", and the same command continues from there" : "");
    return exit_interrupted;
  }
  return report.chart_problem.empty() ? exit_ok : exit_bad_input;
}

namespace {

/// Says that a study ran beside other work, once it has.
void warn_last(const Report& report) {
  const auto others = other_work_in(report.provenance);
  if (others && others->share >= disturbing_share)
    fmt::print(stderr,
               "mss: other work took {:.0f} % of the cores while {} ran: its times came out too long\n",
               100 * others->share, report.name);
}

/// Warns of circumstances that spoil the results before the user waits for them.
void warn_first() {
  const auto others = other_work_now();
  if (others && others->share >= disturbing_share)
    fmt::print(
        stderr,
        "mss: the machine is busy (other work takes {:.0f} % of the cores): times will come out too long\n",
        100 * others->share);
  if (gnuplot_version().empty())
    fmt::print(
        stderr,
        "mss: gnuplot is not installed, so there will be rows but no chart; its package is gnuplot-nox\n");
}

void run_one(const ExperimentInfo& info, StudyChoice choice, int& exit_status) {
  if (!choice.cells.empty())
    choice.options.cells = parse_number_list(choice.cells, "--cells", info.accepts.largest_cells);
  if (info.accepts.integrators) info.accepts.integrators(choice.options.integrators);  // throws
  if (info.accepts.scenes) check_scenes(choice.options.scenes, info.accepts.scenes());
  if (choice.options.devices) info.accepts.devices();  // throws
  check_model_name(choice.options.model);
  if (!choice.part.empty()) choice.options.part = parse_part(choice.part);
  prepare_directory(choice.directory);
  warn_first();
  const Report report = choice.part.empty() ? run_and_write(info, choice.options, choice.directory)
                                            : run_part(info, choice.options, choice.directory);
  exit_status = conclude(report);
  warn_last(report);
}

std::vector<std::string> study_names() {
  std::vector<std::string> names;
  for (const ExperimentInfo& info : experiments()) names.push_back(info.name);
  return names;
}

void run_all(const StudyChoice& choice, int& exit_status) {
  const fs::path directory = choice.directory;
  prepare_directory(directory);
  warn_first();
  StudyClock clock(study_names(), choice.options.quick);
  fmt::print(stderr, "mss: {}\n", clock.announcement());
  std::vector<Report> reports;
  for (const ExperimentInfo& info : experiments()) {
    fmt::print(stderr, "mss: {} ({} of {})\n", info.name, reports.size() + 1, experiments().size());
    reports.push_back(run_and_write(info, choice.options, directory / info.name));
    exit_status = std::max(exit_status, conclude(reports.back()));
    warn_last(reports.back());
    if (interrupted()) break;
    fmt::print(stderr, "mss: {}\n", clock.finished(reports.back().seconds));
  }
  write_page(reports, directory / "index.html");
  fmt::print("wrote {}\n", (directory / "index.html").string());
}

/// Options of a command of two words must come after the second. Throws InputError for others.
void check_order(const CLI::App& command) {
  const CLI::App& before = *command.get_parent();
  if (before.get_parent() == nullptr) return;
  for (const CLI::Option* option : before.get_options())
    if (option->count() > 0)
      throw InputError(
          fmt::format("{} stands before `{}`, whose option it cannot be there; put it after that",
                      option->get_name(), command.get_name()));
}

void add_experiment(CLI::App& app, const ExperimentInfo& info, int& exit_status) {
  const auto choice = std::make_shared<StudyChoice>();
  choice->directory = "out/" + info.name;
  CLI::App& parent = info.under.empty() ? app : *app.get_subcommand(info.under);
  CLI::App* command = parent.add_subcommand(info.name, info.summary);
  add_options(*command, *choice, {info.name}, info.accepts);
  command->callback([&info, choice, command, &exit_status] {
    if (!command->get_subcommands().empty()) return;  // the command is one under this one
    check_order(*command);
    run_one(info, *choice, exit_status);
  });
}

void add_experiments(CLI::App& app, int& exit_status) {
  for (const ExperimentInfo& info : experiments()) add_experiment(app, info, exit_status);
  const auto choice = std::make_shared<StudyChoice>();
  choice->directory = "out/reproduce";
  choice->options.peers = true;
  CLI::App* command =
      app.add_subcommand("reproduce", "every experiment, and one page that shows every chart");
  add_options(*command, *choice, study_names(), {});
  command->callback([choice, &exit_status] { run_all(*choice, exit_status); });
}

}  // namespace

Command experiments_command() { return add_experiments; }

}  // namespace mss::cli
