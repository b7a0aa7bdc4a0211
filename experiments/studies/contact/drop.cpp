// Soft bodies that fall into a box: what they cost, and how deep they press into each other.
#include "experiments/studies/contact/drop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/error.hpp"
#include "core/bodies/bodies_measures.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/simulation/scene_run.hpp"
#include "experiments/studies/contact/scene_text.hpp"
#include "experiments/studies/contact/touching_methods.hpp"

namespace mss::studies::contact {

namespace {

constexpr double drop_cell = 0.05;    ///< [m]
constexpr double drop_pitch = 0.17;   ///< between bodies at the start [m]
constexpr double drop_seconds = 0.4;  ///< simulated: the lower ones lie on each other
constexpr double drop_lost = 0.48;    ///< cells; from half a cell on contact loses a vertex
constexpr double drop_energy = 0.05;  ///< of what is at play

/// The cells of one of five kinds of bodies, whose box has its lowest corner at a place.
std::string shape_text(int kind, const Vec3& at) {
  const std::string scenes = scenes_directory().string();
  const auto mesh = [&](const char* file, double scale, const Vec3& middle, int across) {
    return fmt::format("mesh = \"{}/meshes/{}\"\ncells_across = {}\nmesh_scale = {}\nmesh_translation = {}\n",
                       scenes, file, across, scale, scene_text(at + middle));
  };
  const auto cells = [&](const std::string& cells_of, double cell) {
    return fmt::format("{}\ncell_size = {}\norigin = {}\n", cells_of, cell, scene_text(at));
  };
  switch (kind) {
    case 0:
      return cells("cells = [2, 2, 2]", drop_cell);
    case 1:
      return mesh("sphere.obj", 0.12, Vec3::Constant(0.06), 3);
    case 2:
      return cells("cells = [2, 2, 1]", drop_cell);
    case 3:
      return mesh("torus.obj", 0.14, Vec3::Constant(0.07), 5);
    default:
      return cells(fmt::format("voxels = \"{}/ragged_block.txt\"", scenes), 0.6 * drop_cell);
  }
}

std::string planes_text(int columns) {
  std::string said;
  const double w = columns * drop_pitch;
  for (const auto& [point, normal] :
       {std::pair(Vec3(0, 0, 0), Vec3(0, 0, 1)), std::pair(Vec3(0, 0, 0), Vec3(1, 0, 0)),
        std::pair(Vec3(w, 0, 0), Vec3(-1, 0, 0)), std::pair(Vec3(0, 0, 0), Vec3(0, 1, 0)),
        std::pair(Vec3(0, w, 0), Vec3(0, -1, 0))})
    said += fmt::format("[[plane]]\npoint = {}\nnormal = {}\nfriction = 0.3\n\n", scene_text(point),
                        scene_text(normal));
  return said;
}

}  // namespace

std::string DropRun::name() const {
  return fmt::format("drop {}, {}, {} threads", bodies, integrator, threads);
}

/// In layers of four, or of nine, no two of which are alike, each body turning about another axis.
std::string drop_scene(const DropRun& run) {
  constexpr double margin = 0.015;
  const int columns = run.bodies > 10 ? 3 : 2, layer_size = columns * columns;
  std::string said;
  for (int i = 0; i < run.bodies; ++i) {
    const int layer = i / layer_size, place = i % layer_size, row = place / columns;
    const Vec3 at(margin + drop_pitch * (place % columns), margin + drop_pitch * row,
                  margin + drop_pitch * layer);
    said += "[[body]]\n" + shape_text((i + layer) % 5, at);
    said += fmt::format("start = {{ angular_velocity = {} }}\n\n",
                        scene_text(2 * Vec3(i % 3 - 1, (i + 1) % 3 - 1, layer % 2)));
  }
  said += "[material]\ndensity = 1000\nyoung = 1e6\npoisson = 0.3\n\n[damping]\nratio = 0.2\n\n";
  said +=
      "[contact]\nbodies = true\nfriction = 0.3\nstiffness = 8\n\n[environment]\ngravity = [0, 0, -9.81]\n\n";
  return said + planes_text(columns) + solve_text(run.integrator, run.seconds, frame_step);
}

DropConfig drop_config(const ExperimentOptions& options) {
  DropConfig config;
  const std::vector<std::string> methods = touching_methods(options.integrators);
  const auto has = [&](const char* method) {
    return std::find(methods.begin(), methods.end(), method) != methods.end();
  };
  const auto in_every_number = [](const std::string& method) {
    return method == "verlet" || method == "backward_euler";
  };
  if (options.quick) {
    if (has("verlet"))
      for (const int threads : {1, 2}) config.runs.push_back({5, "verlet", threads, 0.2});
    return config;
  }
  constexpr int by_all = 20, most = 50;
  for (const int bodies : {5, 10, by_all, most})
    for (const std::string& method : methods)
      if (bodies == by_all || in_every_number(method))
        config.runs.push_back({bodies, method, 1, drop_seconds});
  if (has("verlet")) config.runs.push_back({most, "verlet", 2, drop_seconds});
  if (has("backward_euler")) config.runs.push_back({10, "backward_euler", 2, drop_seconds});
  return config;
}

namespace {

struct DropNumbers {
  double dt = no_value, frame = no_value, worst = no_value, pairs = no_value, depth = no_value,
         energy = no_value;
  std::int64_t cells = 0, touches = 0;
  std::uint64_t bits = 0;  ///< of the last state
};

/// FNV-1a of all positions and velocities.
std::uint64_t hash_of(const State<double>& state) {
  std::uint64_t hash = 14695981039346656037U;
  for (const Field<double>* field : {&state.x, &state.v})
    for (const double number : field->array())
      hash = (hash ^ std::bit_cast<std::uint64_t>(number)) * 1099511628211U;
  return hash;
}

/// From frame to frame.
Status follow_drop(const Scene& scene, DropNumbers& n) {
  const Body body(scene.body);
  SceneRun<double> run(scene, body);
  n.dt = run.dt();
  for (const Level& level : run.system().levels()) n.cells += std::int64_t(level.body.cell_count());
  const Measures start = *run.measure();
  const long frames = std::lround(scene.solve.duration / frame_step);
  double seconds = 0, pairs = 0, at_play = 0, gained = 0;
  n.worst = 0;
  Work work;
  for (long i = 1; i <= frames; ++i) {
    const std::int64_t evaluations = work.force_evaluations;
    Status status = Status::ok;
    const double frame = seconds_of([&] { status = run.advance(double(i) * frame_step, work); });
    const std::optional<Measures> m = run.measure();
    if (status == Status::ok && !m) status = Status::non_finite;
    if (status != Status::ok) return status;
    seconds += frame;
    n.worst = std::max(n.worst, frame);
    const ContactReport contact = *measure_bodies(run.system(), run.state()).contact;
    n.touches = std::int64_t(contact.touches);
    n.depth = contact.depth_so_far;
    pairs += double(contact.touches) * double(work.force_evaluations - evaluations);
    at_play =
        std::max(at_play, m->mechanical() + std::max(0.0, start.external_potential - m->external_potential));
    gained = std::max(gained, m->total() - start.total());
  }
  n.frame = seconds / double(frames);
  n.pairs = pairs / seconds;
  n.energy = gained / at_play;
  n.bits = hash_of(run.state());
  return Status::ok;
}

}  // namespace

Table empty_drop() {
  return Table({{"bodies"},
                {"integrator"},
                {"threads"},
                {"cells"},
                {"dt", "s"},
                {"frame", "s"},
                {"worst_frame", "s"},
                {"pairs", "1/s"},
                {"touches"},
                {"depth"},
                {"energy"},
                {"bits"},
                {"status"},
                {"reason"}});
}

void add_drop_run(const DropRun& run, Table& rows) {
  DropNumbers n;
  const auto add = [&](const std::string& status, const std::string& reason) {
    rows.add({std::int64_t(run.bodies), run.integrator, std::int64_t(run.threads), n.cells, n.dt, n.frame,
              n.worst, n.pairs, n.touches, n.depth, n.energy, fmt::format("{:016x}", n.bits), status,
              reason});
  };
  try {
    const Scene scene = parse_scene(drop_scene(run), {fmt::format("solve.threads={}", run.threads)});
    check_solve(scene);
    const Status status = follow_drop(scene, n);
    if (status != Status::ok) return add(std::string(to_string(status)), "");
    add(n.depth > drop_lost ? "sinks_in" : n.energy > drop_energy ? "gains_energy" : "ok", "");
  } catch (const InputError& error) {
    add("refused", error.what());
  }
}

Chart drop_chart(const Table& rows) {
  Chart chart{.title = "Soft bodies dropped into a box: time of a frame",
              .subtitle = "cells of 5 cm, 1 MPa, 1/60 s a frame; one thread; error bars: the worst frame",
              .times = true,
              .x = {.label = "bodies", .logarithmic = true, .low = 4, .high = 63, .ticks = {5, 10, 20, 50}},
              .y = {.label = "time of a frame", .logarithmic = true, .unit = "s"}};
  const Table single = rows.where("threads", 1.0).where("status", "ok");
  for (const std::string& method : single.distinct("integrator")) {
    const Table of_method = single.where("integrator", method);
    ChartSeries series{.label = method};
    for (std::size_t r = 0; r < of_method.size(); ++r) {
      const double frame = of_method.number(r, "frame");
      series.points.push_back(
          {of_method.number(r, "bodies"), frame, frame, of_method.number(r, "worst_frame")});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace mss::studies::contact
