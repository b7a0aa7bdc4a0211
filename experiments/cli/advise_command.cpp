// `mss advise`: the cheapest way to compute a scene that keeps an error.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "core/error.hpp"
#include "core/suggest.hpp"
#include "experiments/advise/advise.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "experiments/plot/gnuplot.hpp"
#include "experiments/simulation/scene_files.hpp"

namespace mss::cli {

using namespace mss::advise;  // of which this is the command

namespace {

namespace fs = std::filesystem;

struct AdviseChoice {
  std::string scene;
  std::vector<std::string> overrides;
  std::string error = "1%";
  std::string of = "displacement";
  std::string budget;
  std::string directory;
  double patience = 60;
  std::optional<int> grid;
};

/// The number a text begins with, and what follows; nothing if it does not begin with one.
std::optional<std::pair<double, std::string>> number_and_rest(const std::string& text) {
  double value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || !std::isfinite(value)) return {};
  return std::pair(value, std::string(end, text.data() + text.size()));
}

double read_error(const std::string& text) {
  const auto read = number_and_rest(text);
  const bool share = read && read->second.empty(), hundredths = read && read->second == "%";
  const double value = !read ? 0 : hundredths ? read->first / 100 : read->first;
  if ((!share && !hundredths) || !(value > 0 && value < 1))
    throw InputError(fmt::format(
        "--error {} is not an error to stay below; give a share above 0 and below 100 %, as in 1%", text));
  return value;
}

/// Seconds per simulated second.
double read_budget(const std::string& text) {
  static const std::vector<std::pair<std::string, double>> units{{"ns/frame", 1e-9 * frames_per_second},
                                                                 {"us/frame", 1e-6 * frames_per_second},
                                                                 {"ms/frame", 1e-3 * frames_per_second},
                                                                 {"s/frame", frames_per_second},
                                                                 {"s/s", 1}};
  const auto read = number_and_rest(text);
  for (const auto& [unit, seconds] : units)
    if (read && read->second == unit && read->first > 0) return read->first * seconds;
  throw InputError(
      fmt::format("--budget {} is not a time; give a positive number of ms/frame (of which there are {:.0f} "
                  "to a simulated "
                  "second), us/frame, ns/frame, s/frame or s/s, as in 16.7ms/frame",
                  text, frames_per_second));
}

ErrorOf read_error_of(const std::string& text) {
  const auto& names = error_names();
  const auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end())
    throw InputError(
        fmt::format("--of {} is unknown; did you mean '{}'? There are displacement, volume, "
                    "frequency and energy",
                    text, nearest(text, names)));
  return ErrorOf(found - names.begin());
}

Chart pareto(const Scene& scene, const Ask& ask, const Advice& advice) {
  constexpr double to_frame = 1e3 / frames_per_second;  // [ms]
  const double least = 1e-4 * ask.error;                // nobody cares how much smaller
  Chart chart{.title = "Error against cost: " + scene.name,
              .subtitle = fmt::format("every candidate that ran to its end; error of {}",
                                      error_names()[std::size_t(ask.of)]),
              .x = {.label = "cost of 1/60 s [ms], this machine", .logarithmic = true},
              .y = {.label = "error", .logarithmic = true}};
  const auto& all = integrators();
  for (std::size_t i = 0; i < all.size(); ++i) {
    ChartSeries series{.label = all[i].name, .style = int(i), .joined = false};
    for (const Trial& trial : advice.trials)
      if (trial.candidate.integrator == all[i].name && trial.share > 0.999 && trial.error > 0 &&
          trial.cost > 0)
        series.points.push_back({trial.cost * to_frame, std::max(trial.error, least)});
    if (!series.points.empty()) chart.series.push_back(series);
  }
  if (std::any_of(advice.trials.begin(), advice.trials.end(),
                  [&](const Trial& trial) { return trial.share > 0.999 && trial.error < least; }))
    chart.y.label = fmt::format("error ({:.2g}: that or less)", least);
  double lowest = ask.error, highest = ask.error, cheapest = std::numeric_limits<double>::infinity();
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) {
      lowest = std::min(lowest, point.y);
      highest = std::max(highest, point.y);
      cheapest = std::min(cheapest, point.x);
    }
  // Decades, in which what is asked lies too, and room for a label below and beside the cheapest.
  const auto decade = [](double value) { return std::pow(10, std::floor(std::log10(value))); };
  chart.y.low = decade(lowest / 2);
  chart.y.high = 10 * decade(highest);
  if (std::isfinite(cheapest)) chart.x.low = decade(cheapest / 2);
  chart.lines.push_back({ReferenceLine::Direction::horizontal, ask.error, "asked"});
  if (ask.budget)
    chart.lines.push_back({ReferenceLine::Direction::vertical, *ask.budget * to_frame, "budget"});
  if (advice.best)
    if (const Trial& best = advice.trials[*advice.best]; best.error > 0)
      chart.marks.push_back({.point = {best.cost * to_frame, std::max(best.error, least)},
                             .label = advice.within_budget ? "advised" : "cheapest that meets it",
                             .left = true});
  return chart;
}

Json meta(const Scene& scene, const SceneFamily& family, const Ask& ask, const Advice& advice,
          const Json& origin) {
  Json json{
      {"scene", scene.name},
      {"error", ask.error},
      {"of", error_names()[std::size_t(ask.of)]},
      {"budget", ask.budget ? Json(*ask.budget) : Json(nullptr)},
      {"advised", nullptr},
      {"explanation", advice.explanation},
      {"reference",
       {{"cell_size", advice.finest_level > 0 ? Json(family.cell_size(advice.finest_level)) : Json(nullptr)},
        {"uncertainty", advice.uncertainty}}},
      {"seconds", advice.seconds}};
  if (advice.best) {
    const Trial& best = advice.trials[*advice.best];
    json["advised"] = {{"settings", family.settings(best.candidate)},
                       {"error", best.error},
                       {"error_against_a_finer_reference", advice.checked_error},
                       {"cost", best.cost},
                       {"within_budget", advice.within_budget}};
  }
  json["configuration"] = Json::parse(scene.resolved);
  json["provenance"] = origin;
  return json;
}

/// The advised scene as a file of its own.
std::string advised_text(const AdviseChoice& choice, const SceneFamily& family, const Ask& ask,
                         const Advice& advice, const fs::path& directory) {
  const fs::path file = scene_file(choice.scene);
  const Trial& best = advice.trials[*advice.best];
  std::vector<std::string> settings = choice.overrides;
  for (const std::string& setting : family.settings(best.candidate)) settings.push_back(setting);
  const Json body = Json::parse(family.asked().resolved)["body"];
  if (body.contains("voxels")) {
    const fs::path voxels = fs::absolute(file.parent_path() / body["voxels"].get<std::string>());
    settings.push_back(
        fmt::format("body.voxels=\"{}\"", fs::proximate(voxels, fs::absolute(directory)).generic_string()));
  }
  return fmt::format(
             "# {}, as `mss advise --error {} --of {}` has it: {:.3g} % off, {:.3g} ms for a frame of "
             "1/60 s.\n",
             family.asked().name, choice.error, error_names()[std::size_t(ask.of)], 100 * best.error,
             best.cost * 1e3 / frames_per_second) +
         scene_text(file, settings);
}

void print(const SceneFamily& family, const Ask& ask, const Advice& advice) {
  if (advice.best) {
    const Trial& best = advice.trials[*advice.best];
    fmt::print("{}: {}\n", family.asked().name,
               advice.within_budget ? "advised" : "the cheapest that meets the error");
    for (const std::string& setting : family.settings(best.candidate)) fmt::print("  {}\n", setting);
    fmt::print("error of {}: {:.3g} %, asked {:.3g} %, the reference's own uncertainty {:.2g} %",
               error_names()[std::size_t(ask.of)], 100 * best.error, 100 * ask.error,
               100 * advice.uncertainty);
    if (std::isfinite(advice.checked_error))
      fmt::print("; against a finer reference {:.3g} %", 100 * advice.checked_error);
    fmt::print("\ncost: {:.3g} ms for a frame of 1/60 s, {:.3g} s for a simulated second\n",
               best.cost * 1e3 / frames_per_second, best.cost);
  }
  fmt::print("{} candidate{} in {:.3g} s\n", advice.trials.size(), advice.trials.size() == 1 ? "" : "s",
             advice.seconds);
}

void run_advise(const AdviseChoice& choice, int& exit_status) {
  Ask ask{.error = read_error(choice.error), .of = read_error_of(choice.of), .patience = choice.patience};
  if (!choice.budget.empty()) ask.budget = read_budget(choice.budget);
  if (!(ask.patience > 0))
    throw InputError(fmt::format("--patience is {}; give a positive number of seconds", choice.patience));
  constexpr int finest_grid = 96;
  if (choice.grid && (*choice.grid < 1 || *choice.grid > finest_grid))
    throw InputError(fmt::format("--grid is {}; give a number from 1 to {}", *choice.grid, finest_grid));
  SceneFamily family(scene_file(choice.scene), choice.overrides);
  const Scene& scene = family.asked();
  const fs::path directory =
      choice.directory.empty() ? fs::path("out") / (scene.name + "_advice") : fs::path(choice.directory);
  prepare_directory(directory);
  if (scene.body.sharing == Sharing::uniform)
    fmt::print(stderr,
               "mss: {}: body.sharing is \"uniform\", which makes another material of other cells; advice is "
               "about the same springs shared as \"weighted\"\n",
               scene.name);
  const Json origin = provenance();
  Advice advice;
  {
    TerminalProgress progress(scene.name);
    advice = choice.grid ? try_all(family, ask, *choice.grid, std::max(4, 2 * *choice.grid), progress)
                         : advise::advise(family, ask, progress);
  }
  write_atomically(directory / "advise.csv", advice_table(family, advice).csv());
  write_atomically(directory / "meta.json", meta(scene, family, ask, advice, origin).dump(2) + "\n");
  if (advice.best && advice.within_budget)
    write_atomically(directory / "advised.toml", advised_text(choice, family, ask, advice, directory));
  else
    fs::remove(directory / "advised.toml");  // of an earlier ask
  if (Chart chart = pareto(scene, ask, advice); has_points(chart)) {
    chart.footer = provenance_line(origin);
    draw(chart, directory / "advise");
  } else {
    for (const char* picture : {"advise.svg", "advise.png"}) fs::remove(directory / picture);
  }
  print(family, ask, advice);
  fmt::print("see {}\n", directory.string());
  if (advice.stopped) {
    fmt::print(stderr, "mss: {} was interrupted; what was tried is kept\n", scene.name);
    exit_status = exit_interrupted;
  } else if (!advice.explanation.empty()) {
    fmt::print(stderr, "mss: {}: {}\n", scene.name, advice.explanation);
    exit_status = exit_check_failed;
  }
}

void add(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand(
      "advise", "the cheapest way to compute a scene that keeps an error: cells, springs, method, step");
  const auto choice = std::make_shared<AdviseChoice>();
  command->add_option("scene", choice->scene, "Scene file (TOML), or a name from `mss list scenes`")
      ->required();
  command->add_option("--error", choice->error, "Largest error there may be, as in 1%")
      ->capture_default_str();
  command->add_option("--of", choice->of, "What it is of: displacement, volume, frequency or energy")
      ->capture_default_str();
  command->add_option("--budget", choice->budget, "Most that a frame of 1/60 s may take, as in 16.7ms/frame");
  command->add_option("--patience", choice->patience, "Seconds that a reference may take")
      ->capture_default_str();
  command->add_option("--grid", choice->grid,
                      "Try everything, cells split up to so many times the coarsest, instead of searching");
  command->add_option("--out", choice->directory, "Directory for the results (default ./out/<scene>_advice)");
  command->add_option("--set", choice->overrides, "Change a value of the scene: table.key=value")->take_all();
  command->callback([choice, &exit_status] { run_advise(*choice, exit_status); });
}

}  // namespace

Command advise_command() { return add; }

}  // namespace mss::cli
