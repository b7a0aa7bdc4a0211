#include "experiments/simulation/expectation.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "core/base/error.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;
using Row = std::map<std::string, double>;

Row row_of(const SeriesRow& m) {
  Row row;
  for (const MeasureColumn& column : columns_of(m)) row[std::string(column.name)] = column.value(m);
  for_each_component(m.reactions, [&](const std::string& name, double force) { row[name] = force; });
  return row;
}

std::string present_name(const std::string& column) {
  for (const auto& [before, now] : renamed_columns)
    if (column == before) return std::string(now);
  return column;
}

/// The rows of a file of numbers, by column. NaN and infinities are read as what they are.
std::vector<Row> read_numbers(const fs::path& file) {
  const auto lines = parse_csv(read_file(file));
  if (lines.size() < 2) throw InputError(fmt::format("{} has no rows", file.string()));
  std::vector<Row> rows;
  for (std::size_t r = 1; r < lines.size(); ++r) {
    Row row;
    for (std::size_t i = 0; i < lines.front().size(); ++i) {
      const std::string cell = i < lines[r].size() ? lines[r][i] : "";
      double value = 0;
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
      if (error != std::errc() || end != cell.data() + cell.size())
        throw InputError(
            fmt::format("{}:{}: {} = '{}' is not a number", file.string(), r + 1, lines.front()[i], cell));
      row[present_name(lines.front()[i])] = value;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

Vec3 vector_of(const fs::path& file, const Row& row, const std::array<const char*, 3>& columns) {
  Vec3 v;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto found = row.find(columns[a]);
    if (found == row.end())
      throw InputError(fmt::format("{}:1: column {} is missing", file.string(), columns[a]));
    v[Eigen::Index(a)] = found->second;
  }
  return v;
}

/// What a summary.json says of the status, and of the scene if it says that.
struct SummaryText {
  std::string status, scene;
  double dt;
};
SummaryText read_summary(const fs::path& file) {
  const Json summary = Json::parse(read_file(file), nullptr, false);
  if (!summary.is_object() || !summary.contains("status") || !summary["status"].is_string())
    throw InputError(fmt::format("{} is not JSON with a text \"status\"", file.string()));
  const Json scene = summary.value("scene", Json());
  const Json dt = summary.value("dt", Json(no_value));
  return {summary["status"].get<std::string>(), scene.is_string() ? scene.get<std::string>() : "",
          dt.is_null()     ? 0  // of methods that choose their steps, which end where they are told to
          : dt.is_number() ? dt.get<double>()
                           : no_value};
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

SceneEnd read_scene_end(const fs::path& directory) {
  const SummaryText summary = read_summary(directory / "summary.json");
  SceneEnd end{.status = summary.status, .scene = summary.scene, .dt = summary.dt};
  const std::vector<Row> series = read_numbers(directory / "series.csv");
  end.first = series.front();
  end.last = series.back();
  const fs::path particles = directory / "particles.csv";
  for (const Row& row : read_numbers(particles))
    end.particles.push_back({.rest = vector_of(particles, row, {"rest_x", "rest_y", "rest_z"}),
                             .x = vector_of(particles, row, {"x", "y", "z"}),
                             .v = Vec3::Zero()});
  return end;
}

std::vector<std::string> doubts_about(const Scene& scene, const SceneEnd& end) {
  std::vector<std::string> doubts;
  if (!end.scene.empty() && end.scene != scene.name)
    doubts.push_back(fmt::format("these are results of the scene '{}', not of '{}'", end.scene, scene.name));
  const auto t = end.last.find("t");
  if (end.status != "ok" || t == end.last.end() || std::isnan(end.dt)) return doubts;
  const double most = 0.51 * end.dt + 1e-6 * scene.solve.duration;
  if (std::abs(t->second - scene.solve.duration) > most)
    doubts.push_back(fmt::format("they end at t = {:.6g} s, and the scene at solve.duration = {:.6g} s",
                                 t->second, scene.solve.duration));
  return doubts;
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
