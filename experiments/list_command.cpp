// `mss list`: what there is, one line each.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <utility>

#include "core/error.hpp"
#include "core/suggest.hpp"
#include "experiments/commands.hpp"
#include "experiments/experiment.hpp"
#include "experiments/model.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/linear_solver.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;
using Lines = std::vector<std::pair<std::string, std::string>>;

Lines integrator_lines() {
  Lines lines;
  for (const IntegratorInfo& info : integrators()) lines.emplace_back(info.name, info.summary);
  return lines;
}

Lines linear_solver_lines() {
  Lines lines;
  for (const LinearSolverInfo& info : linear_solvers()) lines.emplace_back(info.name, info.summary);
  return lines;
}

Lines experiment_lines() {
  Lines lines;
  for (const ExperimentInfo& info : experiments()) lines.emplace_back(info.command(), info.summary);
  return lines;
}

Lines scene_lines() {
  const fs::path directory = scenes_directory();
  if (directory.empty()) {
    fmt::print(stderr,
               "mss: the scenes that come with the program are neither in its source tree nor beside it\n");
    return {};
  }
  Lines lines;
  for (const auto& entry : fs::directory_iterator(directory))
    if (entry.path().extension() == ".toml")
      lines.emplace_back(entry.path().stem().string(), scene_description(entry.path()));
  std::sort(lines.begin(), lines.end());
  return lines;
}

void print(const Lines& lines, const char* indent) {
  std::size_t width = 0;
  for (const auto& [name, text] : lines) width = std::max(width, name.size());
  for (const auto& [name, text] : lines) fmt::print("{}{:<{}}  {}\n", indent, name, width, text);
}

void list(const std::string& kind) {
  const std::vector<std::pair<std::string, Lines (*)()>> kinds{{"integrators", integrator_lines},
                                                               {"linear_solvers", linear_solver_lines},
                                                               {"models", models},
                                                               {"scenes", scene_lines},
                                                               {"experiments", experiment_lines}};
  std::vector<std::string> names;
  for (const auto& [name, lines] : kinds) {
    names.push_back(name);
    if (kind == name) return print(lines(), "");
  }
  if (!kind.empty())
    throw InputError(fmt::format("there is no list of '{}'; did you mean '{}'?", kind, nearest(kind, names)));
  for (const auto& [name, lines] : kinds) {
    fmt::print("{}\n", name);
    print(lines(), "  ");
  }
}

void add(CLI::App& app, int&) {
  CLI::App* command =
      app.add_subcommand("list", "what there is: integrators, linear solvers, models, scenes, experiments");
  const auto kind = std::make_shared<std::string>();
  command->add_option("kind", *kind,
                      "integrators, linear_solvers, models, scenes or experiments; all if left out");
  command->callback([kind] { list(*kind); });
}

}  // namespace

fs::path scenes_directory() {
  std::error_code error;
  const fs::path beside = fs::read_symlink("/proc/self/exe", error).parent_path() / "scenes";
  for (const fs::path& candidate : {fs::path(MSS_SCENES_DIRECTORY), beside})
    if (fs::is_directory(candidate, error)) return candidate;
  return {};
}

fs::path scene_file(const std::string& given) {
  if (fs::is_regular_file(given) || fs::path(given).has_parent_path() || fs::path(given).has_extension())
    return given;
  const fs::path listed = scenes_directory() / (given + ".toml");
  if (fs::exists(listed)) return listed;  // whatever else has that name here, such as a run's directory
  if (fs::exists(given)) return given;
  std::vector<std::string> names;
  for (const auto& [name, description] : scene_lines()) names.push_back(name);
  throw_unknown(given, names, "scene", "scenes");
}

std::string scene_description(const fs::path& scene) {
  std::ifstream stream(scene);
  std::string line;
  std::getline(stream, line);
  if (line.empty() || line[0] != '#') return {};
  line.erase(0, line.find_first_not_of("# "));
  return line;
}

Command list_command() { return add; }

}  // namespace mss
