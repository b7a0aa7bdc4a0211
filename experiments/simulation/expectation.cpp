#include "experiments/simulation/expectation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>

#include "core/base/error.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "experiments/harness/json.hpp"
#include "experiments/harness/number_file.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/scene_run.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;
using Row = std::map<std::string, double>;

Row row_of(const Measures& m) {
  Row row;
  for (const MeasureColumn& column : columns_of(m)) row[std::string(column.name)] = column.value(m);
  return row;
}

Row row_of(const SeriesRow& m) {
  Row row = row_of(static_cast<const Measures&>(m));
  for_each_component(m.reactions, [&](const std::string& name, double force) { row[name] = force; });
  for_each_column(m.bodies, [&](const std::string& name, const char*, double number) { row[name] = number; });
  return row;
}

/// Columns that follow from velocities, too.
bool needs_velocities(const std::string& quantity) {
  static const std::set<std::string> names{
      "kinetic",    "total",      "max_speed",          energy_drift,         "momentum_x",
      "momentum_y", "momentum_z", "angular_momentum_x", "angular_momentum_y", "angular_momentum_z"};
  return names.contains(quantity);
}

/// A summary.json, as far as it is needed.
struct SummaryText {
  std::string status, scene;
  double dt;
};
SummaryText read_summary(const fs::path& file) {
  const Json summary = Json::parse(read_file(file), nullptr, false);
  if (!summary.is_object() || !summary.contains("status") || !summary["status"].is_string())
    throw InputError(fmt::format("{} is not JSON with a text \"status\"", file.string()));
  const Json scene = summary.value("scene", Json());
  const Json dt = summary.value("dt", Json());
  return {summary["status"].get<std::string>(), scene.is_string() ? scene.get<std::string>() : "",
          dt.is_number() ? dt.get<double>() : 0};  // methods that choose their steps end where they should
}

/// Throws InputError if results end at another time than the scene.
void check_end(const NumberFile& series, const Scene& scene, double dt) {
  const double t = series.column("t").back();
  const double most = 0.51 * dt + 1e-3 * scene.solve.duration;
  if (!(std::abs(t - scene.solve.duration) <= most))
    throw InputError(fmt::format(
        "{} ends at t = {:.6g} s, and the scene at solve.duration = {:.6g} s; give results of its whole time",
        series.file().string(), t, scene.solve.duration));
}

/// The row of every particle. Throws InputError if one is missing or repeated, or of another body.
std::vector<std::size_t> rows_of_particles(const NumberFile& file, const SolidSystem<double>& system) {
  const std::size_t count = system.particles().size(), none = file.rows();
  std::vector<std::size_t> rows(count, none);
  const std::vector<std::size_t> ids = file.ids("id");
  const std::array columns{&file.column("rest_x"), &file.column("rest_y"), &file.column("rest_z")};
  for (std::size_t row = 0; row < ids.size(); ++row) {
    const auto refuse = [&](const std::string& what) {
      throw InputError(fmt::format("{}:{}: {}", file.file().string(), file.line(row), what));
    };
    if (ids[row] >= count)
      refuse(
          fmt::format("particle {} is not one of the scene's {} (from 0 to {})", ids[row], count, count - 1));
    if (rows[ids[row]] != none) refuse(fmt::format("particle {} is there twice", ids[row]));
    rows[ids[row]] = row;
    const Vec3 rest((*columns[0])[row], (*columns[1])[row], (*columns[2])[row]),
        right = system.rest_position(system.particles()[ids[row]]);
    constexpr double single_precision = 1e-5;
    if (!((rest - right).norm() <= single_precision * (system.cell_size() + right.norm())))
      refuse(
          fmt::format("particle {} rests at [{:.6g}, {:.6g}, {:.6g}], and the scene's at [{:.6g}, {:.6g}, "
                      "{:.6g}]; give those of mss run, in its order",
                      ids[row], rest[0], rest[1], rest[2], right[0], right[1], right[2]));
  }
  const auto missing = std::find(rows.begin(), rows.end(), none);
  if (missing != rows.end())
    throw InputError(fmt::format("{}: particle {} is missing: there are {}, and the scene has {}",
                                 file.file().string(), missing - rows.begin(), ids.size(), count));
  return rows;
}

/// The state that particles.csv has; velocities are zero where it has none.
State<double> read_state(const NumberFile& file, const Scene& scene, SolidSystem<double>& system) {
  const std::vector<std::size_t> rows = rows_of_particles(file, system);
  State<double> state = system.rest_state();
  state.t = scene.solve.duration;
  state.v.array() = 0;
  const auto read = [&](const std::array<const char*, 3>& names, Field<double>& field) {
    const std::array columns{&file.column(names[0]), &file.column(names[1]), &file.column(names[2])};
    for (std::size_t id = 0; id < rows.size(); ++id)
      field.set(system.particles()[id],
                {(*columns[0])[rows[id]], (*columns[1])[rows[id]], (*columns[2])[rows[id]]});
  };
  const auto read_all = [&] {
    read({"x", "y", "z"}, state.x);
    if (file.has("vx")) read({"vx", "vy", "vz"}, state.v);
  };
  read_all();
  if (!system.refined_body()) return state;
  system.constrain(state.t, state.x, state.v);  // particles that follow others
  read_all();
  return state;
}

/// Empty, or which particle is at no place, in words.
std::string lost_particle(const SolidSystem<double>& system, const State<double>& state) {
  for (std::size_t id = 0; id < system.particles().size(); ++id) {
    const std::ptrdiff_t site = system.particles()[id];
    if (!state.x.at(site).allFinite() || !state.v.at(site).allFinite())
      return fmt::format("NaN or infinity in particle {}", id);
  }
  return "";
}

/// Throws InputError if velocities are needed and not there.
void check_velocities(const NumberFile& particles, const Scene& scene) {
  for (const Expectation& e : scene.expectations)
    if (needs_velocities(e.quantity) && follows_from_state(scene, e.quantity) && !particles.has("vx"))
      throw InputError(fmt::format("{}:1: columns vx, vy, vz are missing, from which {} follows; give them",
                                   particles.file().string(), e.quantity));
}

/// What positions and velocities do not determine is taken from series.csv.
void add_past(const NumberFile& series, const Scene& scene, SceneEnd& end) {
  for (const Expectation& e : scene.expectations) {
    if (follows_from_state(scene, e.quantity)) continue;
    const std::string column = e.quantity == energy_drift ? "total" : e.quantity;
    end.first[column] = series.column(column).front();
    end.last[column] = series.column(column).back();
  }
}

/// Mean displacement of the particles whose rest position lies in a box, widened by 1e-9 cell.
std::vector<double> displacement(const Scene& scene, const SceneEnd& end, const Box& box) {
  const double margin = 1e-9 * scene.body.cell_size;
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const ParticleRecord& p : end.particles) {
    if (((p.rest - box.lower).array() < -margin).any() || ((p.rest - box.upper).array() > margin).any())
      continue;
    sum += p.x - p.rest;
    ++count;
  }
  if (count == 0) return {};
  return {sum[0] / count, sum[1] / count, sum[2] / count};
}

/// Mean displacement of the mesh's vertices whose rest position lies in a box.
std::vector<double> surface_displacement(const Scene& scene, const SceneEnd& end, const Box& box) {
  const Body body(scene.body);
  if (end.particles.size() != body.particle_count()) return {};
  Field<double> moved(body.lattice().size);
  for (std::size_t id = 0; id < end.particles.size(); ++id)
    moved.set(body.sites()[id], end.particles[id].x - end.particles[id].rest);
  const TriangleMesh mesh = scene.mesh->surface();
  const EmbeddedSurface surface(mesh, scene.body.voxels, scene.body.cell_size, scene.body.origin);
  const std::vector<std::size_t> vertices = vertices_in(mesh, box, 1e-9 * scene.body.cell_size);
  Vec3 sum = Vec3::Zero();
  for (const std::size_t vertex : vertices) sum += surface.at(vertex, moved) / double(vertices.size());
  return {sum[0], sum[1], sum[2]};
}

/// The result to compare; empty if there is none.
std::vector<double> found(const Scene& scene, const SceneEnd& end, const Expectation& e) {
  if (e.quantity == mean_displacement)
    return e.on_surface ? surface_displacement(scene, end, e.box) : displacement(scene, end, e.box);
  const bool drift = e.quantity == energy_drift;
  const std::string column = drift ? "total" : e.quantity;
  const auto first = end.first.find(column), last = end.last.find(column);
  if (first == end.first.end() || last == end.last.end()) return {};
  return {drift ? last->second / first->second - 1 : last->second};
}

std::string shown(const std::vector<double>& numbers) {
  if (numbers.size() == 1) return fmt::format("{:.8g}", numbers.front());
  return fmt::format("[{:.8g}]", fmt::join(numbers, ", "));
}

}  // namespace

SceneEnd scene_end_of(const SimulationResult& result) {
  return {.status = std::string(to_string(result.status)),
          .first = row_of(result.series.front()),
          .last = row_of(result.series.back()),
          .particles = result.particles};
}

SceneEnd scene_end_of(const Scene& scene, const SolidSystem<double>& system, const State<double>& end) {
  SceneEnd found{.status = std::string(to_string(Status::ok)),
                 .first = row_of(measure(system, start_state(system, scene))),
                 .last = row_of(measure(system, end))};
  for (const std::ptrdiff_t site : system.particles())
    found.particles.push_back({.rest = system.rest_position(site),
                               .x = end.x.at(site),
                               .v = end.v.at(site),
                               .mass = system.mass(site)});
  return found;
}

SceneEnd read_scene_end(const Scene& of, const fs::path& directory) {
  const SummaryText summary = read_summary(directory / "summary.json");
  const NumberFile series(directory / "series.csv"), particles(directory / "particles.csv");
  Scene scene = of;
  scene.solve.threads = 1;
  const Body body(scene.body);
  const std::unique_ptr<const RefinedBody> refined = refined_body_of(scene);
  const OtherBodies others = other_bodies(scene);
  const auto system = make_solid<double>(scene, body, refined.get(), others);
  check_velocities(particles, scene);
  const State<double> state = read_state(particles, scene, *system);
  SceneEnd end{.status = summary.status};
  if (const std::string lost = lost_particle(*system, state); lost.empty())
    end = scene_end_of(scene, *system, state);
  else if (summary.status == to_string(Status::ok))
    end.status = lost;
  if (summary.status != to_string(Status::ok))
    end.status = summary.status;
  else
    check_end(series, scene, summary.dt);
  add_past(series, scene, end);
  end.scene = summary.scene;
  return end;
}

std::vector<std::string> doubts_about(const Scene& scene, const SceneEnd& end) {
  if (end.scene.empty() || end.scene == scene.name) return {};
  return {fmt::format("these are results of the scene '{}', not of '{}'", end.scene, scene.name)};
}

bool follows_from_state(const Scene& scene, const std::string& quantity) {
  for (const char* of_the_past : {"hold_", "plane_", "obstacle_", "body_", "contact_"})
    if (quantity.starts_with(of_the_past)) return false;
  static const std::set<std::string> of_the_past{"total", energy_drift, "relaxing_energy", "relaxed_energy"};
  return !scene.body.relaxation.acts() || !of_the_past.contains(quantity);
}

std::vector<Deviation> compare_with_expectations(const Scene& scene, const SceneEnd& end) {
  std::vector<Deviation> wrong;
  if (end.status != "ok") wrong.push_back({scene.name, "status", "ok", end.status, "must be the same"});
  for (const Expectation& e : scene.expectations) {
    const std::vector<double> now = found(scene, end, e);
    bool right = now.size() == e.value.size();
    for (std::size_t i = 0; right && i < now.size(); ++i) right = std::abs(now[i] - e.value[i]) <= e.within;
    if (!right)
      wrong.push_back({scene.name, e.quantity, shown(e.value), now.empty() ? "" : shown(now),
                       fmt::format("may be off by {:.4g}", e.within)});
  }
  return wrong;
}

}  // namespace mss
