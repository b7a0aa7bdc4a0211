#include "experiments/view/picture.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/forces/spring_law.hpp"
#include "core/measures/particle_measures.hpp"

namespace mss::view {

namespace {

constexpr Colour free_particle{0.10F, 0.12F, 0.15F}, held_particle{0.84F, 0.37F, 0.0F};
constexpr Colour plain_spring{0.20F, 0.25F, 0.32F}, grid_line{0.45F, 0.48F, 0.52F};

bool is_held(const HeldSites& held, std::ptrdiff_t site) {
  return held.holds(site, 0) && held.holds(site, 1) && held.holds(site, 2);
}

}  // namespace

const std::vector<QuantityInfo>& quantities() {
  static const std::vector<QuantityInfo> all{
      {DisplayedQuantity::stretch, "stretch", "",
       "largest | length / rest length - 1 | of a particle's springs", 0, 0.01},
      {DisplayedQuantity::volume_ratio, "volume ratio", "",
       "volume / volume at rest, mean of a particle's cells", 0.995, 1.005},
      {DisplayedQuantity::jacobian, "Jacobian", "",
       "smallest corner volume / h^3 of a particle's cells; below 0: inside out", 0.995, 1.005},
      {DisplayedQuantity::speed, "speed", "m/s", "of a particle", 0, 1e-3}};
  return all;
}

const QuantityInfo& info_of(DisplayedQuantity quantity) { return quantities()[std::size_t(quantity)]; }

std::vector<float> values_at(const std::vector<std::ptrdiff_t>& sites, DisplayedQuantity quantity,
                             const std::vector<Level>& levels, const Field<double>& x,
                             const Field<double>& v) {
  std::vector<float> values;
  values.reserve(sites.size());
  const auto fill = [&](auto&& at) {
    constexpr double most = 1e30;  // bodies that fly apart leave the range of single precision first
    auto level = levels.begin();
    for (const std::ptrdiff_t site : sites) {  // ascending
      while (level + 1 != levels.end() && (level + 1)->first <= site) ++level;
      values.push_back(float(std::clamp(at(*level, site - level->first), -most, most)));
    }
  };
  switch (quantity) {
    case DisplayedQuantity::stretch:
      fill([&](const Level& level, std::ptrdiff_t site) { return stretch_at(level, x, site); });
      break;
    case DisplayedQuantity::volume_ratio:
      fill([&](const Level& level, std::ptrdiff_t site) { return volume_ratio_at(level, x, site); });
      break;
    case DisplayedQuantity::jacobian:
      fill([&](const Level& level, std::ptrdiff_t site) { return jacobian_at(level, x, site); });
      break;
    case DisplayedQuantity::speed:
      fill([&](const Level& level, std::ptrdiff_t site) { return v.at(level.first + site).norm(); });
      break;
  }
  return values;
}

Mark mark(const Vec3& position, const Colour& colour, double opacity) {
  const auto byte = [](double share) { return static_cast<std::uint8_t>(std::lround(255 * share)); };
  return {{float(position[0]), float(position[1]), float(position[2])},
          {byte(colour[0]), byte(colour[1]), byte(colour[2]), byte(opacity)}};
}

void add_springs(Marks& lines, const Level& level, const Field<double>& x, const ValueRange* stretch) {
  const Body& body = level.body;
  lines.reserve(lines.size() + 2 * body.spring_count());
  body.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double, double) {
    const Vec3 from = x.at(level.first + a), to = x.at(level.first + b);
    Colour colour = plain_spring;
    if (stretch != nullptr)
      colour = map_colour(
          stretch->share(std::abs(spring_strain((to - from).norm(), body.rest_length(slot.kind)))));
    lines.push_back(mark(from, colour));
    lines.push_back(mark(to, colour));
  });
}

void add_particles(Marks& points, const std::vector<Level>& levels, const Field<double>& x,
                   const std::vector<Hold>& holds) {
  const HeldSites held(levels, holds);
  for (const auto& [body, first] : levels)
    for (const std::ptrdiff_t site : body.sites())
      points.push_back(mark(x.at(first + site), is_held(held, first + site) ? held_particle : free_particle));
}

void add_grid(Marks& lines, const GridPlane& plane) {
  const Vec3 across = plane.normal.unitOrthogonal(), along = plane.normal.cross(across);
  const double reach = plane.lines * plane.spacing;
  for (int i = -plane.lines; i <= plane.lines; ++i)
    for (const auto& [u, w] : {std::pair(across, along), std::pair(along, across)}) {
      const double offset = i * plane.spacing;
      const double fade = 1 - 0.85 * std::abs(offset) / reach;
      lines.push_back(mark(plane.point + offset * u - reach * w, grid_line, 0.12));
      lines.push_back(mark(plane.point + offset * u, grid_line, 0.7 * fade));
      lines.push_back(mark(plane.point + offset * u, grid_line, 0.7 * fade));
      lines.push_back(mark(plane.point + offset * u + reach * w, grid_line, 0.12));
    }
}

void add_obstacle(Marks& faces, Marks& lines, const ObstacleSurface& obstacle, double t) {
  const TriangleMesh mesh = obstacle.triangles(t);
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return mesh.vertices[std::size_t(triangle[i])]; };
    const Vec3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    const auto light = float(0.86 + 0.1 * normal[2] + 0.03 * normal[0]);
    for (std::size_t i = 0; i < 3; ++i)
      faces.push_back(mark(corner(i), {0.86F * light, 0.86F * light, 0.88F * light}));
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = std::size_t(triangle[i]), b = std::size_t(triangle[(i + 1) % 3]);
      if (a > b) continue;  // the triangle on the other side draws it
      lines.push_back(mark(mesh.vertices[a], grid_line, 0.6));
      lines.push_back(mark(mesh.vertices[b], grid_line, 0.6));
    }
  }
}

namespace {

Vec3 size_of(const BodyConfig& body) {
  return body.cell_size * Vec3(body.voxels.nx(), body.voxels.ny(), body.voxels.nz());
}

GridPlane ground_below(const Body& body, const Environment& environment, double spacing) {
  const BodyConfig& config = body.config();
  const Vec3 size = size_of(config);
  const HeldSites held(body, environment.holds);
  const bool stands = std::all_of(body.sites().begin(), body.sites().end(), [&](std::ptrdiff_t site) {
    const bool lowest = body.rest_position(site)[2] < config.origin[2] + config.cell_size / 2;
    return !lowest || held.holds(site, 2);
  });
  const double down =
      size.maxCoeff() * (stands ? 1e-3 : 0.5);  // a hair at least: no lines through what lies on it
  Vec3 point = config.origin + Vec3(size[0] / 2, size[1] / 2, -down);
  for (const Obstacle& obstacle : environment.obstacles)
    for (const Vec3& vertex : ObstacleSurface(obstacle).triangles(0).vertices)
      point[2] = std::min(point[2], vertex[2] - 1e-3 * size.maxCoeff());
  for (const int axis : {0, 1}) point[axis] = spacing * std::round(point[axis] / spacing);
  return {.point = point, .spacing = spacing, .lines = 15};
}

}  // namespace

std::vector<GridPlane> grids_of(const Body& body, const Environment& environment) {
  const Vec3 size = size_of(body.config()), centre = body.config().origin + size / 2;
  const double spacing = round_range(0, size.maxCoeff(), 0).step;
  if (environment.planes.empty()) return {ground_below(body, environment, spacing)};
  std::vector<GridPlane> grids;
  for (const Plane& plane : environment.planes)
    grids.push_back({.point = centre - (plane.gap(centre) + 1e-3 * size.maxCoeff()) * plane.normal,
                     .normal = plane.normal,
                     .spacing = spacing,
                     .lines = 15});
  return grids;
}

}  // namespace mss::view
