// What a program that draws 60 pictures a second asks of a solver: a third of a second of motion in steps of
// a frame or a few a frame, by every implicit family (a method, its solver, and how many iterations it is
// granted) beside explicit methods at their safe steps; and where a body comes to rest. Families are judged
// by the true motion, and by what backward Euler would answer if it were solved to convergence.
#include "experiments/studies/frames/frames.hpp"

#include <fmt/format.h>

#include "experiments/simulation/held_cube.hpp"
#include "experiments/studies/frames/total.hpp"

namespace mss::studies::frames {

namespace {

constexpr const char* caption =
    "A third of a second of a cube of 1 m, held at one face and released under gravity. Each run has so many "
    "steps a frame of 1/60 s and so many iterations a step; of a family that has several the first chart "
    "shows the quickest with an error of at most 10 percent, and curves of the second are envelopes, the "
    "runs that no other of the family beats in both time and error. The error is the root mean square over "
    "frames and particles of the distance from the true motion (damped Verlet at a quarter of its safe "
    "step), over that of the displacement. Distances from backward Euler are those from its own motion at "
    "one step a frame, solved to convergence. Explicit methods run at their safe step, those that need at "
    "most 1.2 times the fewest force evaluations. Medians of interleaved runs, set-up included, one thread. "
    "Runs that failed are markers on the upper edge. Shape matching has no modulus: its alpha is chosen so "
    "that the free end hangs as far through at rest as that of the springs, if it can (frames_fits.csv). "
    "The cube at rest is found from straight, at several tolerances. Charts of the cube show one scene of "
    "each kind, tables all. Total errors: of a cube and an L held under gravity and of a ball that comes to "
    "the ground, in cells of several sizes with the same viscosity, from the motion in cells half as large "
    "as the finest; of time alone from the true motion in the same cells; at the places of the coarsest "
    "cells, over the displacement. Explicit methods at their safe step and at a quarter of it; linear "
    "systems to 1e-3. Horizontal lines are the error of the cells alone; errors of time below 1e-4 are "
    "drawn there, totals above 2 not. A total below both its parts is chance: errors of opposite sign. "
    "Families are tried with fewer choices than in `regimes`.";

std::vector<FrameScene> scenes(bool quick) {
  if (quick) return {{.name = "small", .cells = 4, .young = 1e5}};
  return {{.name = "stiff_damped_14", .cells = 14, .young = 1e7, .damping_ratio = 0.5},
          {.name = "stiff_14", .cells = 14, .young = 1e7},
          {.name = "medium_14", .cells = 14, .young = 1e6},
          {.name = "soft_7", .cells = 7, .young = 1e5},
          {.name = "medium_7", .cells = 7, .young = 1e6},
          {.name = "stiff_7", .cells = 7, .young = 1e7},
          {.name = "rubber_7", .cells = 7, .young = 1e6, .poisson = 0.45},
          {.name = "very_stiff_damped_7", .cells = 7, .young = 1e9, .damping_ratio = 0.5}};
}

Json names_of(const std::vector<Family>& families) {
  Json all = Json::array();
  for (const Family& f : families)
    all.push_back({{"name", f.name()}, {"iterations", f.iterations}, {"steps_per_frame", f.steps}});
  return all;
}

Json totals_of(const TotalConfig& c) {
  Json problems = Json::array();
  for (const TotalProblem& p : c.problems)
    problems.push_back({{"scene", p.scene},
                        {"young", p.young},
                        {"ratio", p.ratio},
                        {"cells", p.cells},
                        {"reference_cells", p.reference_cells}});
  return {{"problems", problems},
          {"families", names_of(c.families)},
          {"repetitions", c.repetitions},
          {"most_seconds", c.most_seconds}};
}

Json configuration(const FramesConfig& c, const RestConfig& rest, const TotalConfig& totals) {
  Json described = Json::object(), at_rest = Json::object();
  for (const FrameScene& scene : c.scenes) described[scene.name] = scene.description();
  for (const FrameScene& scene : rest.scenes) at_rest[scene.name] = scene.description();
  return {{"body", "cube of 1 m, 1000 kg/m^3, held at the face x = 0, released straight under gravity"},
          {"scenes", described},
          {"families", names_of(c.families)},
          {"frames", c.frames},
          {"frame", frame},
          {"repetitions", c.repetitions},
          {"seconds_per_row", c.seconds_per_row},
          {"threads", c.threads},
          {"rest",
           {{"scenes", at_rest},
            {"families", names_of(rest.families)},
            {"tolerances", rest.tolerances},
            {"repetitions", rest.repetitions},
            {"seconds_per_row", rest.seconds_per_row}}},
          {"totals", totals_of(totals)}};
}

std::string summary_lines(const Table& summary) {
  std::string lines;
  for (std::size_t r = 0; r < summary.size(); ++r)
    lines += fmt::format(
        "{:<20} error {:<5g} {}\n", summary.text(r, "scene"), summary.number(r, "error"),
        summary.text(r, "status") != "ok"
            ? summary.text(r, "status")
            : fmt::format("{}, {} iterations, {} steps a frame: {:.3g} ms, {:.3g} times the fastest explicit",
                          summary.text(r, "method"), summary.number(r, "iterations"),
                          summary.number(r, "steps_per_frame"), 1e3 * summary.number(r, "seconds"),
                          summary.number(r, "over_explicit")));
  return lines;
}

ExperimentResult run_frames(const ExperimentOptions& options, Progress& progress) {
  const FramesConfig config = frames_config(options);
  const RestConfig rest = rest_config(options);
  const TotalConfig totals = total_config(options);
  FrameTables tables = measure_frames(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config, rest, totals)};
  const Table summary = frames_summary(tables.rows);
  result.summary = summary_lines(summary);
  Table iterations = frames_iterations(tables.rows), at_rest = measure_rest(rest, progress);
  const TotalTables in_all = measure_totals(totals, progress);
  if (progress.stopped()) result.status = Status::interrupted;
  result.tables = {{"frames", std::move(tables.rows)},
                   {"frames_summary", summary},
                   {"frames_iterations", std::move(iterations)},
                   {"frames_fits", std::move(tables.fits)},
                   {"frames_rest", std::move(at_rest)}};
  for (NamedTable& table : total_files(in_all)) result.tables.push_back(std::move(table));
  return result;
}

/// Errors of explicit methods and of few iterations are the same on every machine.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  FramesConfig config = frames_config({.quick = true});
  if (!options.quick) config.scenes.push_back({.name = "medium_7"});
  config.repetitions = 1;
  config.threads = options.threads;
  return measure_frames(config, progress)
      .rows.select({"scene", "method", "iterations", "steps_per_frame", "error", "distance", "status"});
}

}  // namespace

FramesConfig frames_config(const ExperimentOptions& options) {
  FramesConfig config{
      .scenes = scenes(options.quick),
      .families = {
          {.integrator = "backward_euler_linear", .linear = "cholmod"},
          {.integrator = "backward_euler_linear", .steps = {1, 2, 4}},
          {.integrator = "backward_euler", .nonlinear = "projective", .iterations = {1, 2, 5, 10, 20, 50}},
          {.integrator = "backward_euler", .nonlinear = "lbfgs", .iterations = {1, 2, 3, 5, 10}},
          {.integrator = "backward_euler", .nonlinear = "nonlinear_cg", .iterations = {1, 2, 3, 5, 10}},
          {.integrator = "backward_euler", .nonlinear = "additive_cg", .iterations = {1, 2, 5, 10, 20}},
          {.integrator = "backward_euler", .nonlinear = "lbfgs", .iterations = {2, 5}, .steps = {2, 4}},
          {.integrator = "tr_bdf2", .nonlinear = "lbfgs", .iterations = {2, 3, 4}, .steps = {1, 2, 3, 4}},
          {.integrator = "generalized_alpha", .nonlinear = "lbfgs", .iterations = {5}, .steps = {1, 2, 4}},
          {.integrator = "xpbd", .iterations = {1}, .steps = {1, 2, 5, 10, 20, 50}},
          {.integrator = "xpbd", .iterations = {2, 5, 10, 20, 50}},
          {.integrator = "vbd", .iterations = {1, 2, 5, 10, 20, 50}},
          {.integrator = "vbd", .iterations = {2, 5}, .steps = {4, 10}},
          {.integrator = "vbd", .iterations = {5, 10, 20, 50}, .chebyshev_radius = 0.9},
          {.integrator = "vbd", .iterations = {10, 20, 50}, .chebyshev_radius = 0.95},
          {.integrator = "shape_matching", .steps = {1, 2, 4, 10}}}};
  if (options.quick) config.repetitions = 1;
  return config;
}

RestConfig rest_config(const ExperimentOptions& options) {
  RestConfig config{.scenes = {{.name = "cube_7", .cells = 7}, {.name = "cube_20", .cells = 20}},
                    .families = {{.integrator = "static", .linear = "cholmod"},
                                 {.integrator = "static", .linear = "multigrid"},
                                 {.integrator = "static", .nonlinear = "projective"},
                                 {.integrator = "static", .nonlinear = "lbfgs"},
                                 {.integrator = "dynamic_relaxation"}},
                    .tolerances = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}};
  if (options.quick) {
    config.scenes = {{.name = "cube_4", .cells = 4}};
    config.repetitions = 1;
  }
  return config;
}

ExperimentInfo experiment() {
  return {.name = "frames",
          .summary = "motions at 60 frames a second, and rest: time against error by method and iterations",
          .run = run_frames,
          .draw = draw_frames,
          .baseline = {.keys = {"scene", "method", "iterations", "steps_per_frame"},
                       .rules = {{"error", 1e-3, 1e-6}, {"distance", 1e-3, 1e-6}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::frames
