// What the particles of a lattice cost that a scene does not need: the same motions by lattices in larger
// cells, as they are and with moduli matched to the slowest vibrations of the body, and by models of a few
// coordinates. Scenes are in scenes.cpp, movers.cpp steps and draws them, runs.cpp measures.
#include "experiments/studies/reduce/reduce.hpp"

#include <fmt/format.h>

namespace mss::studies::reduce {

namespace {

constexpr const char* caption =
    "Half a second at 60 frames a second of a beam of 1 x 0.25 x 0.25 m and a plate of 1 x 0.5 x 0.125 m, "
    "clamped at one end, E = 10 MPa, and of a free cube of 1 m, E = 1 MPa; 1000 kg/m^3, nu = 0.3, viscous. "
    "G and R: let go under gravity, or from rest under a load on its end, so that the end goes 2, 15 and 60 "
    "percent of the length; T: from rest with its end turned; P: pressed on a patch of its top; C15: as G15, "
    "a "
    "plane under its tip. "
    "The error is the largest root mean square over particles of the distance from the reference at a frame, "
    "over the largest displacement of the reference, of free bodies after the rigid motion that fits best "
    "and over the deformation; the reference is the body's own lattice by RK4 at a quarter of its safe step. "
    "The cost of a frame is that of its steps and of the positions of all particles of the body: what has "
    "larger cells is interpolated. Lattices are stepped by velocity Verlet at 0.9 of the largest stable "
    "step. Matched: E, or E and nu (both), are such that the slowest bending or torsion is the body's, or "
    "the six "
    "slowest vibrations are near its own (modes). "
    "Gain: the cost of the cheapest lattice of no larger error over that of a model, in the same run. One "
    "thread, processor time, medians of interleaved samples. Set-up is no part of a cost (column setup_ms). "
    "Left out: bodies that are no boxes.";

constexpr std::size_t beam = 0, cube = 1, plate = 2;

std::vector<Subject> subjects(bool quick) {
  const std::vector<ReducedModel> held{{"modal", 8},         {"modal", 16},      {"modal_warped", 8},
                                       {"modal_warped", 16}, {"modal_cubic", 8}, {"modal_cubic", 12},
                                       {"modal_cubic", 16},  {"modal_cubic", 20}};
  const int of_beam = quick ? 16 : 24, of_cube = quick ? 8 : 12;
  std::vector<Subject> all(3);
  all[beam].solid = {.name = "beam", .size = {1, 0.25, 0.25}, .cells = of_beam};
  all[cube].solid = {.name = "cube", .cells = of_cube, .young = 1e6, .clamped = false};
  all[plate].solid = {.name = "plate", .size = {1, 0.5, 0.125}, .cells = of_beam};
  all[beam].models = all[plate].models = held;
  all[cube].models = {{"modal", 18}};
  all[cube].all_modes = all[plate].all_modes = true;
  for (int n = 4; n <= of_beam; n += 4) all[beam].cells.push_back(n);
  for (const int n : {2, 3, 4, 5, 6, 8, 10, 12})
    if (n <= of_cube) all[cube].cells.push_back(n);
  for (int n = 8; n <= of_beam; n += 8) all[plate].cells.push_back(n);
  return all;
}

ReduceScene weight(const std::string& name, double gravity, double meant) {
  return {.name = name,
          .label = fmt::format("{}: gravity, {:g} percent", name, 100 * meant),
          .description = fmt::format("let go under gravity of {:g} m/s^2", gravity),
          .amount = {0, 0, -gravity},
          .meant = meant};
}

ReduceScene release(const std::string& name, double force, double meant) {
  return {.name = name,
          .label = fmt::format("{}: let go, {:g} percent", name, 100 * meant),
          .description = fmt::format("bent by {:g} N on its end face, let go", force),
          .happening = Happening::release,
          .amount = {0, 0, -force},
          .meant = meant};
}

ReduceScene twist(const std::string& name, double degrees) {
  return {.name = name,
          .label = fmt::format("{}: twist, {:g} degrees", name, degrees),
          .description = fmt::format("its end face turned by {:g} degrees, let go", degrees),
          .happening = Happening::twist,
          .amount = {degrees, 0, 0}};
}

ReduceScene spin(const std::string& name, double rate) {
  return {.name = name,
          .label = fmt::format("{}: spin, {:g} rad/s", name, rate),
          .description = fmt::format("turned at {:g} rad/s about (1, 2, 3)", rate),
          .solid = cube,
          .happening = Happening::spin,
          .amount = rate * Vec3(1, 2, 3).normalized()};
}

std::vector<ReduceScene> scenes() {
  constexpr double middling = 32.85;
  ReduceScene pressed{.name = "P",
                      .label = "P: pressed patch",
                      .description = "2 kN press on 0.125 x 0.0625 m of its top at midspan",
                      .happening = Happening::patch,
                      .amount = {0, 0, -2000}};
  ReduceScene touching{.name = "C15",
                       .label = "C15: contact",
                       .description = fmt::format("let go under gravity of {:g} m/s^2 on to a plane 5 cm "
                                                  "below its lower face",
                                                  middling),
                       .happening = Happening::contact,
                       .amount = {0, 0, -middling}};
  ReduceScene flat = weight("plate_z", 12, 0), edgewise = weight("plate_y", 0, 0);
  flat.solid = edgewise.solid = plate;
  flat.label = "plate, gravity across";
  edgewise.label = "plate, gravity edgewise";
  edgewise.description = "let go under gravity of 120 m/s^2 along its width";
  edgewise.amount = {0, -120, 0};
  ReduceScene bent = weight("G15", middling, 0.15);
  bent.losses = true;
  return {weight("G2", 4.358, 0.02),
          bent,
          weight("G60", 151.1, 0.6),
          release("R2", 205, 0.02),
          release("R15", 1570, 0.15),
          release("R60", 9359, 0.6),
          twist("T15", 15),
          twist("T60", 60),
          pressed,
          touching,
          flat,
          edgewise,
          spin("S3", 3),
          spin("S10", 10),
          spin("S25", 25)};
}

Json configuration(const ReduceConfig& c) {
  Json subjects = Json::object(), scenes = Json::object();
  for (const Subject& s : c.subjects) {
    Json models = Json::array();
    for (const ReducedModel& m : s.models) models.push_back({{"name", m.name}, {"modes", m.modes}});
    subjects[s.solid.name] = {{"size", {s.solid.size[0], s.solid.size[1], s.solid.size[2]}},
                              {"young", s.solid.young},
                              {"clamped", s.solid.clamped},
                              {"cells", s.cells},
                              {"models", models}};
  }
  for (const ReduceScene& s : c.scenes)
    scenes[s.name] = c.subjects[s.solid].solid.name + ": " + s.description;
  return {{"subjects", subjects},
          {"scenes", scenes},
          {"face_shares", {0.5, 1}},
          {"reference", "rk4 at a quarter of its safe step"},
          {"explicit", "velocity_verlet at 0.9 of its largest stable step"},
          {"frames", c.frames},
          {"frame", frame},
          {"repetitions", c.repetitions},
          {"sample_seconds", c.sample_seconds}};
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const ReduceScene& scene : scenes()) names.push_back(scene.name);
  return names;
}

/// Of every scene the largest gain of a model of a few coordinates with an error of at most a tenth.
std::string lines_of(const Table& rows) {
  std::string lines;
  for (const std::string& scene : rows.distinct("scene")) {
    const Table of = rows.where("scene", scene).where("status", "ok");
    std::size_t best = of.size();
    for (std::size_t r = 0; r < of.size(); ++r)
      if (of.number(r, "modes") > 0 && of.number(r, "error") <= 0.1 &&
          (best == of.size() || of.number(r, "gain_matched") > of.number(best, "gain_matched")))
        best = r;
    lines +=
        best == of.size()
            ? fmt::format("{:<8} no model of a few coordinates errs by less than 10 percent\n", scene)
            : fmt::format(
                  "{:<8} {} of {} coordinates: error {:.2g} %, gain {:.3g} over lattices, {:.3g} "
                  "over unmatched ones\n",
                  scene, of.text(best, "model"), of.number(best, "modes"), 100 * of.number(best, "error"),
                  of.number(best, "gain_matched"), of.number(best, "gain_unmatched"));
  }
  return lines;
}

ExperimentResult run_reduce(const ExperimentOptions& options, Progress& progress) {
  const ReduceConfig config = reduce_config(options);
  ReduceTables tables = measure_reduce(config, progress);
  const std::string summary = lines_of(tables.rows);
  return {.status = tables.status,
          .tables = {{"reduce", std::move(tables.rows)},
                     {"reduce_scenes", std::move(tables.scenes)},
                     {"reduce_matched", std::move(tables.matched)}},
          .caption = caption,
          .summary = summary,
          .configuration = configuration(config)};
}

/// Errors are the same on every machine, costs are not.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  ReduceConfig config = reduce_config({.quick = true});
  config.repetitions = 1;
  config.sample_seconds = 0;
  if (options.quick) {
    std::erase_if(config.scenes, [](const ReduceScene& s) { return s.name != "G15" && s.name != "T15"; });
    for (ReduceScene& scene : config.scenes) scene.losses = false;
  }
  return measure_reduce(config, progress)
      .rows.select({"scene", "model", "setting", "cells", "modes", "face_share", "young", "poisson", "error",
                    "status"});
}

}  // namespace

ReduceConfig reduce_config(const ExperimentOptions& options) {
  ReduceConfig config{.subjects = subjects(options.quick), .scenes = scenes()};
  check_scenes(options.scenes, scene_names());
  if (!options.scenes.empty())
    std::erase_if(config.scenes, [&](const ReduceScene& s) {
      return std::find(options.scenes.begin(), options.scenes.end(), s.name) == options.scenes.end();
    });
  return config;
}

ExperimentInfo experiment() {
  return {
      .name = "reduce",
      .summary =
          "lattices in larger cells, with matched moduli, and bodies of a few coordinates: error and cost",
      .accepts = {.scenes = scene_names},
      .times = true,
      .run = run_reduce,
      .draw = draw_reduce,
      .baseline = {.keys = {"scene", "model", "setting", "cells", "modes", "face_share"},
                   .rules = {{"young", 1e-4}, {"poisson", 1e-4, 1e-4}, {"error", 1e-3, 1e-6}},
                   .table = baseline_table}};
}

}  // namespace mss::studies::reduce
