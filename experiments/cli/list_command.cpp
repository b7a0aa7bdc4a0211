// `mss list`: integrators, solvers, models, devices, scenes and experiments, one line each.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "core/device/device.hpp"
#include "core/scene/scene_reference.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss::cli {

namespace {

using Lines = std::vector<std::pair<std::string, std::string>>;

Lines integrator_lines() {
  Lines lines;
  for (const IntegratorInfo& info : integrators())
    lines.emplace_back(info.name, info.variant_of.empty()
                                      ? info.summary
                                      : fmt::format("{} (a variant of {}: {})", info.summary, info.variant_of,
                                                    info.variation));
  return lines;
}

Lines linear_solver_lines() {
  Lines lines;
  for (const LinearSolverInfo& info : linear_solvers()) lines.emplace_back(info.name, info.summary);
  return lines;
}

Lines nonlinear_solver_lines() {
  Lines lines;
  for (const NonlinearSolverInfo& info : nonlinear_solvers()) lines.emplace_back(info.name, info.summary);
  return lines;
}

Lines experiment_lines() {
  Lines lines;
  for (const ExperimentInfo& info : experiments()) lines.emplace_back(info.command(), info.summary);
  return lines;
}

/// What solve.device may be. Where there is none, says why.
Lines device_lines() {
  Lines lines{{"cpu", "the processor"}};
  try {
    for (const DeviceInfo& info : list_devices())
      lines.emplace_back(fmt::format("gpu:{}", lines.size() - 1),
                         info.fault.empty()
                             ? fmt::format("{}, OpenGL {}, {}, single and double", info.name, info.version,
                                           info.is_software ? "in software" : "a card")
                             : fmt::format("unusable: {}: {}", info.name, info.fault));
  } catch (const InputError& error) {
    lines.emplace_back("gpu", error.what());
  }
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
                                                               {"nonlinear_solvers", nonlinear_solver_lines},
                                                               {"models", models},
                                                               {"devices", device_lines},
                                                               {"scenes", listed_scenes},
                                                               {"experiments", experiment_lines},
                                                               {"scene_keys", scene_key_lines}};
  std::vector<std::string> names;
  for (const auto& [name, lines] : kinds) {
    names.push_back(name);
    if (kind == name) return print(lines(), "");
  }
  if (!kind.empty())
    throw InputError(fmt::format("there is no list of '{}'; {}give one of {}", kind, question(kind, names),
                                 fmt::join(names, ", ")));
  for (const auto& [name, lines] : kinds) {
    if (name == std::string("scene_keys")) continue;  // as long as all others together
    fmt::print("{}\n", name);
    print(lines(), "  ");
  }
}

void add_list(CLI::App& app, int&) {
  CLI::App* command = app.add_subcommand("list",
                                         "names that the other commands take: integrators, solvers, models, "
                                         "devices, scenes, experiments; keys of scenes");
  const auto kind = std::make_shared<std::string>();
  command->add_option(
      "kind", *kind,
      "integrators, linear_solvers, nonlinear_solvers, models, devices, scenes or experiments; all if "
      "left out; or scene_keys");
  command->callback([kind] { list(*kind); });
}

}  // namespace

Command list_command() { return add_list; }

}  // namespace mss::cli
