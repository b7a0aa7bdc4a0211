// A body on the floor: what is run of it.
#include "experiments/studies/contact/floor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/shapes.hpp"
#include "experiments/studies/contact/touching_methods.hpp"

namespace mss::studies::contact {

namespace {

constexpr double cell = 0.05;  // [m]

BodyConfig cube() { return {.voxels = VoxelGrid::box(4, 4, 4), .cell_size = cell}; }

/// Without cells on its sides, two edges and a corner, and with a hole through its middle.
BodyConfig ragged_cube() {
  constexpr int missing[][3]{{3, 0, 0}, {3, 0, 1}, {0, 1, 1}, {0, 3, 2}, {0, 3, 3}, {2, 3, 1}, {3, 2, 2},
                             {1, 0, 2}, {1, 1, 1}, {1, 1, 2}, {1, 2, 2}, {0, 0, 0}, {3, 3, 0}};
  BodyConfig config = cube();
  for (const auto& c : missing) config.voxels.set(c[0], c[1], c[2], false);
  return config;
}

BodyConfig torus_of_mesh() {
  MeshFill fill = fill_mesh(torus(0.1, 0.05, 48, 24), {.cell_size = cell});
  return {.voxels = std::move(fill.voxels),
          .contents = std::move(fill.contents),
          .content_of = std::move(fill.content_of),
          .cell_size = cell};
}

/// Of explicit Euler no step is guaranteed; the energy-momentum method takes a third of the time of all, and
/// is right where implicit midpoint is.
bool runs_only_if_named(const std::string& name) {
  return name == "explicit_euler" || name == "energy_momentum" || is_of_high_order(name);
}

/// Methods of fixed step, each with its variants that are compared.
std::vector<std::string> floor_integrators(const std::vector<std::string>& named) {
  std::vector<std::string> all;
  for (const std::string& name : named)
    if (find_integrator(name).stepping == Stepping::fixed) all.push_back(name);
  if (!named.empty()) return all;
  for (const IntegratorInfo& info : integrators()) {
    if (info.stepping != Stepping::fixed || runs_only_if_named(info.name)) continue;
    if (info.iterates && info.springs_only)
      for (const char* passes : {":1", ":5", ":20"}) all.push_back(info.name + passes);
    else
      all.push_back(info.name);
    if (info.name == "backward_euler" || info.name == "tr_bdf2") all.push_back(info.name + "/lbfgs");
    if (info.name == "backward_euler") all.push_back(info.name + "/projective");
  }
  return all;
}

constexpr double middle_young = 1e6;  ///< [Pa]; other bodies take it by methods with a limit alone

bool is_wanted(const FloorRun& run) {
  const IntegratorInfo& method = find_integrator(run.integrator);
  const bool safe = run.step.dt == 0, frames = run.step.dt == floor_steps().front().dt;
  const bool sags = run.scene.task == FloorTask::rest || run.scene.task == FloorTask::loaded;
  const bool is_cube = run.shape == floor_shapes().front();
  if (method.limit) return safe;
  return !safe && (method.has_modulus || !sags) && (is_cube || (frames && run.young != middle_young));
}

}  // namespace

const std::vector<FloorScene>& floor_scenes() {
  static const std::vector<FloorScene> all{{.task = FloorTask::rest,
                                            .name = "rest",
                                            .label = "rests",
                                            .quantity = "sag of the top",
                                            .unit = "",
                                            .seconds = 6},
                                           {.task = FloorTask::loaded,
                                            .name = "loaded",
                                            .label = "rests, loaded",
                                            .quantity = "sag of the top",
                                            .unit = "",
                                            .burden = 5,
                                            .seconds = 6},
                                           {.task = FloorTask::stick,
                                            .name = "stick",
                                            .label = "sticks, 19°",
                                            .quantity = "creep in 1.5 s",
                                            .unit = "m",
                                            .degrees = 19,
                                            .friction = 0.5,
                                            .seconds = 6},
                                           {.task = FloorTask::slide,
                                            .name = "slide",
                                            .label = "slides, 30°",
                                            .quantity = "acceleration",
                                            .unit = "",
                                            .degrees = 30,
                                            .friction = 0.3,
                                            .seconds = 1.5},
                                           {.task = FloorTask::drop,
                                            .name = "drop",
                                            .label = "falls 10 cm",
                                            .quantity = "energy gained",
                                            .unit = "",
                                            .friction = 0.5,
                                            .height = 0.1,
                                            .seconds = 1},
                                           {.task = FloorTask::groove,
                                            .name = "groove",
                                            .label = "lies in a groove",
                                            .quantity = "creep in 1.5 s",
                                            .unit = "m",
                                            .degrees = 45,
                                            .friction = 0.2,
                                            .height = 0.01,
                                            .seconds = 6}};
  return all;
}

const std::vector<std::string>& floor_shapes() {
  static const std::vector<std::string> all{"cube", "ragged", "torus"};
  return all;
}

BodyConfig floor_body(const std::string& shape, double young) {
  const std::vector<std::string>& all = floor_shapes();
  if (std::find(all.begin(), all.end(), shape) == all.end()) throw std::logic_error("no shape " + shape);
  BodyConfig config = shape == "cube" ? cube() : shape == "ragged" ? ragged_cube() : torus_of_mesh();
  config.density = 1000;
  config.damping = {.law = Damping::Law::ratio, .zeta = 0.1};
  config.fill({.young = young, .poisson = 0.3}, 0.5);
  return config;
}

const std::vector<FloorStep>& floor_steps() {
  static const std::vector<FloorStep> all{{"1/60 s", 1.0 / 60}, {"1/240 s", 1.0 / 240}, {"safe", 0}};
  return all;
}

std::string FloorRun::name() const {
  return fmt::format("{}, {}, {}, {:g} Pa, {}", shape, scene.name, integrator, young, step.name);
}

FloorConfig floor_config(const ExperimentOptions& options) {
  FloorConfig config{.shapes = floor_shapes(),
                     .integrators = floor_integrators(options.integrators),
                     .youngs = {1e5, middle_young, 1e7},
                     .steps = floor_steps()};
  if (!options.quick) return config;
  config.shapes = {floor_shapes().front()};
  config.steps = {floor_steps().front(), floor_steps().back()};
  if (options.integrators.empty())
    config.integrators = {"verlet", "backward_euler", "backward_euler/lbfgs", "xpbd:1", "xpbd:20", "vbd:20"};
  return config;
}

std::vector<FloorRun> floor_runs(const FloorConfig& config) {
  std::vector<FloorRun> runs;
  for (const std::string& shape : config.shapes)
    for (const FloorScene& scene : floor_scenes())
      for (const std::string& integrator : config.integrators)
        for (const double young : config.youngs)
          for (const FloorStep& step : config.steps)
            if (const FloorRun run{shape, scene, integrator, young, step}; is_wanted(run))
              runs.push_back(run);
  return runs;
}

std::string floor_summary(const Table& rows) {
  std::string lines;
  for (const std::string& integrator : rows.distinct("integrator")) {
    const Table of_method = rows.where("integrator", integrator);
    lines += fmt::format("{:<25} of {:3} runs {:3} ok", integrator, of_method.size(),
                         of_method.where("status", "ok").size());
    for (const std::string& status : of_method.distinct("status"))
      if (status != "ok") lines += fmt::format(", {} {}", of_method.where("status", status).size(), status);
    lines += "\n";
  }
  return lines;
}

}  // namespace mss::studies::contact
