// What a scene's user should know before it runs: materials, meshes, planes, and what has no effect.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "core/body/material.hpp"
#include "core/environment/obstacle.hpp"
#include "core/scene/scene.hpp"

namespace mss {

namespace {

/// By part, which others it meets in a cell or in cells that share a spring, those with an edge in common.
std::vector<std::vector<bool>> meetings(const BodyConfig& body) {
  const std::size_t parts = body.parts.size() + 1;
  std::vector<std::vector<bool>> meets(parts, std::vector<bool>(parts));
  const VoxelGrid& voxels = body.voxels;
  const auto meet = [&](const std::array<int, 3>& a, const std::array<int, 3>& b) {
    if (!voxels.at(a[0], a[1], a[2]) || !voxels.at(b[0], b[1], b[2])) return;
    for (const auto& [p, of_a] : body.contents[body.content_of[voxels.index(a[0], a[1], a[2])]])
      for (const auto& [q, of_b] : body.contents[body.content_of[voxels.index(b[0], b[1], b[2])]])
        meets[std::size_t(p)][std::size_t(q)] = meets[std::size_t(q)][std::size_t(p)] = true;
  };
  constexpr std::array<std::array<int, 3>, 10> steps{{{0, 0, 0},
                                                      {1, 0, 0},
                                                      {0, 1, 0},
                                                      {0, 0, 1},
                                                      {1, 1, 0},
                                                      {1, -1, 0},
                                                      {0, 1, 1},
                                                      {0, 1, -1},
                                                      {1, 0, 1},
                                                      {1, 0, -1}}};
  for (int k = 0; k < voxels.nz() && !body.content_of.empty(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i)
        for (const auto& [x, y, z] : steps) meet({i, j, k}, {i + x, j + y, k + z});
  return meets;
}

/// Above a contrast of some thousand a shared spring is the stiffer part's alone.
void add_contrasts(const BodyConfig& body, std::vector<std::string>& warnings) {
  constexpr double most = 1000;
  const std::vector<Part> parts = body.all_parts();
  const std::vector<std::vector<bool>> meets = meetings(body);
  const auto named = [&](std::size_t part) {
    return part == 0 ? std::string("[material]") : fmt::format("part \"{}\"", parts[part].name);
  };
  const auto stiffness = [&](std::size_t part) {
    return cubic_stiffness(parts[part].springs, body.cell_size).young(Vec3::UnitX());
  };
  for (std::size_t a = 0; a < parts.size(); ++a)
    for (std::size_t b = 0; b < parts.size(); ++b)
      if (const double ratio = stiffness(a) / stiffness(b); meets[a][b] && ratio > most)
        warnings.push_back(fmt::format(
            "{} is {:.3g} times as stiff as {} where they meet: beyond {} times springs that both "
            "share follow the stiffer one alone, so the joint lies up to a cell off",
            named(a), ratio, named(b), most));
}

double longest_edge(const TriangleMesh& mesh) {
  double longest = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    longest = std::max({longest, (b - a).norm(), (c - b).norm(), (a - c).norm()});
  }
  return longest;
}

/// What was found in the meshes of a scene.
void add_meshes(const SceneBody& scene, bool has_planes, std::vector<std::string>& warnings) {
  if (!scene.mesh) return;
  for (std::size_t i = 0; i < scene.mesh->reports.size(); ++i)
    for (const std::string& note : scene.mesh->reports[i].notes())
      warnings.push_back(
          fmt::format("{}: {}", i == 0 ? scene.mesh->file : scene.mesh->part_files[i - 1], note));
  if (!scene.contact_surface || !has_planes) return;
  constexpr double most = 2;
  if (const double edge = longest_edge(*scene.contact_surface) / scene.body.cell_size; edge > most)
    warnings.push_back(
        fmt::format("body.contact_on = \"surface\": planes touch vertices alone, and the mesh has edges of "
                    "up to {:.3g} cells, "
                    "between whose ends particles sink in; give a finer mesh or \"particles\"",
                    edge));
}

/// Calls visit(place) with the lower corner [m] of every cell at rest.
template <class Visit>
void for_each_cell(const BodyConfig& body, Visit&& visit) {
  body.voxels.for_each_place([&](int i, int j, int k) {
    if (body.voxels.at(i, j, k)) visit(body.origin + body.cell_size * Vec3(i, j, k));
  });
}

/// Calls visit(x) for the corners of the cell whose lower corner is at a place.
template <class Visit>
void for_each_corner(const BodyConfig& body, const Vec3& lower, Visit&& visit) {
  for (int corner = 0; corner < 8; ++corner)
    if ((corner & body.voxels.flat_axes()) == 0)
      visit(lower + body.cell_size * Vec3(corner & 1, corner >> 1 & 1, corner >> 2));
}

/// Calls visit(x) for what planes touch of a body at rest: the vertices of its surface, or else the corners
/// of its cells.
template <class Visit>
void for_each_touched(const SceneBody& scene, Visit&& visit) {
  if (const auto& surface = scene.contact_surface) {
    for (const Vec3& vertex : surface->vertices) visit(vertex);
    return;
  }
  for_each_cell(scene.body, [&](const Vec3& lower) { for_each_corner(scene.body, lower, visit); });
}

/// Share of the cells' volume that is behind a plane, exact where the plane is along faces of cells.
double share_behind(const Plane& plane, const BodyConfig& body) {
  double behind = 0, all = 0;
  Vec3 edges = Vec3::Constant(body.cell_size);
  for (int axis = 0; axis < 3; ++axis)
    if ((body.voxels.flat_axes() >> axis & 1) != 0) edges[axis] = 0;
  const double extent = edges.dot(plane.normal.cwiseAbs());
  for_each_cell(body, [&](const Vec3& lower) {
    const double gap = plane.gap(lower + edges / 2);
    behind += extent > 0 ? std::clamp(0.5 - gap / extent, 0.0, 1.0) : double(gap < 0);
    ++all;
  });
  return behind / all;
}

bool contains(const Box& box, const Vec3& x, double margin) {
  return ((x - box.lower).array() >= -margin).all() && ((x - box.upper).array() <= margin).all();
}

/// What is held from the beginning, where planes do nothing.
bool is_held(const Scene& scene, const Vec3& x) {
  const std::vector<Hold>& holds = scene.environment.holds;
  return std::any_of(holds.begin(), holds.end(), [&](const Hold& hold) {
    return !hold.surface && contains(hold.box, x, 1e-9 * scene.body.cell_size);
  });
}

/// What becomes of what starts behind a plane, or in an obstacle.
const char* fate_behind(ContactLaw law) {
  switch (law) {
    case ContactLaw::impulse:
      return "it is pushed out, which deforms the body";
    case ContactLaw::penalty:
      return "its forces throw it out";
    default:
      return "the law \"thesis\" leaves it there";
  }
}

/// A body that starts behind a plane, or partly so.
void add_start_behind(const Scene& scene, const SceneBody& one, std::size_t index,
                      std::vector<std::string>& warnings) {
  const Plane& plane = scene.environment.planes[index];
  const double rounding = 1e-9 * one.body.cell_size;
  bool whole = true;  // none is in front
  double deepest = 0;
  for_each_touched(one, [&](const Vec3& x) {
    const double depth = -plane.gap(x);
    const bool held = is_held(scene, x);
    whole &= depth > -rounding && !held;
    if (depth > rounding && !held) deepest = std::max(deepest, depth);
  });
  if (deepest > 0 && whole)
    warnings.push_back(fmt::format(
        "plane.{}: the whole body starts behind it; its normal is to point to the side of the body", index));
  else if (deepest > 0)
    warnings.push_back(fmt::format(
        "plane.{}: {:.3g} percent of the body start behind it, up to {:.3g} m deep: {}; move the body or the "
        "plane by as much",
        index, 100 * share_behind(plane, one.body), deepest, fate_behind(plane.contact)));
}

/// A restitution that was chosen as if it were the body's, of a plane or an obstacle by its name.
template <class Touched>
void add_restitution(const Scene& scene, const Touched& touched, const std::string& name,
                     std::vector<std::string>& warnings) {
  const VoxelGrid& voxels = scene.body.voxels;
  const bool is_one_cell = voxels.nx() * voxels.ny() * voxels.nz() == 1;
  if (touched.contact != ContactLaw::impulse || is_one_cell || touched.restitution == Touched{}.restitution)
    return;
  warnings.push_back(fmt::format(
      "{}.restitution = {} is that of each particle, not of the body: how high a body of several cells "
      "bounces follows from its springs and their damping; leave it out unless that is meant",
      name, touched.restitution));
}

/// A body and an obstacle that begin in each other.
void add_start_inside(const Scene& scene, const SceneBody& one, const ObstacleSurface& surface,
                      const std::string& name, std::vector<std::string>& warnings) {
  const BodyConfig& body = one.body;
  const double rounding = 1e-9 * body.cell_size;
  double deepest = 0;
  for_each_touched(one, [&](const Vec3& x) {
    if (!is_held(scene, x)) deepest = std::max(deepest, -surface.gap(x, 0));
  });
  bool has_centre = false;
  for_each_cell(body, [&](const Vec3& lower) {
    const Vec3 upper = lower + Vec3::Constant(body.cell_size);
    has_centre |= body.is_solid() && contains({lower, upper}, surface.centre(0), 0);
  });
  if (deepest > rounding)
    warnings.push_back(
        fmt::format("{}: the body starts inside it, up to {:.3g} m deep: {}; move one of the two by as much",
                    name, deepest, fate_behind(surface.obstacle().contact)));
  else if (has_centre)
    warnings.push_back(fmt::format(
        "{}: its centre starts inside the body, between what touches: it goes where particles let it pass; "
        "move one of the two",
        name));
}

/// What particles pass on both sides.
void add_small_obstacle(const SceneBody& one, const ObstacleSurface& surface, const std::string& name,
                        std::vector<std::string>& warnings) {
  const TriangleMesh triangles = surface.triangles(0);
  const auto [lower, upper] = bounding_box(triangles);
  if (one.contact_surface || (upper - lower).maxCoeff() >= one.body.cell_size) return;
  warnings.push_back(
      fmt::format("{}: it is smaller than a cell, and what touches it are particles, between which it may "
                  "pass; give smaller cells",
                  name));
}

void add_obstacles(const Scene& scene, const SceneBody& one, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < scene.environment.obstacles.size(); ++i) {
    const ObstacleSurface surface(scene.environment.obstacles[i]);
    const std::string name = fmt::format("obstacle.{}", i);
    add_start_inside(scene, one, surface, name, warnings);
    add_small_obstacle(one, surface, name, warnings);
  }
}

/// Calls visit(x) for the corners of cells in both boxes, some of them more than once.
template <class Visit>
void for_each_corner_in(const Box& a, const Box& b, const BodyConfig& body, Visit&& visit) {
  const Box box{a.lower.cwiseMax(b.lower), a.upper.cwiseMin(b.upper)};
  if (((box.lower - box.upper).array() > 1e-9 * body.cell_size).any()) return;
  for_each_cell(body, [&](const Vec3& lower) {
    for_each_corner(body, lower, [&](const Vec3& x) {
      if (contains(box, x, 1e-9 * body.cell_size)) visit(x);
    });
  });
}

/// How far two holds would have a particle apart along an axis during a run, at most [m].
double most_apart(const Hold& a, const Hold& b, const Vec3& rest, int axis, double duration) {
  constexpr int samples = 8;
  double most = 0;
  for (int i = 0; i <= samples; ++i) {
    const double t = duration * i / samples;
    most = std::max(most, std::abs(prescribed_motion(a, rest, t).position[axis] -
                                   prescribed_motion(b, rest, t).position[axis]));
  }
  return most;
}

/// Two holds that prescribe different motions of the same particles; of a mesh's faces they are not looked
/// at.
void add_contradictions(const Scene& scene, const BodyConfig& body, std::vector<std::string>& warnings) {
  const std::vector<Hold>& holds = scene.environment.holds;
  for (std::size_t b = 1; b < holds.size(); ++b)
    for (std::size_t a = 0; a < b; ++a) {
      if (holds[a].surface || holds[b].surface) continue;
      double apart = 0;
      for_each_corner_in(holds[a].box, holds[b].box, body, [&](const Vec3& x) {
        for (int axis = 0; axis < 3; ++axis)
          if (holds[a].axes[std::size_t(axis)] && holds[b].axes[std::size_t(axis)])
            apart = std::max(apart, most_apart(holds[a], holds[b], x, axis, scene.solve.duration));
      });
      if (apart > 1e-9 * body.cell_size)
        warnings.push_back(fmt::format(
            "hold.{} and hold.{} prescribe different motions of the same particles, up to {:.3g} m apart: "
            "they obey hold.{}; give boxes without common particles, or different axes",
            a, b, apart, b));
    }
}

/// A load that acts on what is held: it changes the hold's force and nothing else.
void add_loads_on_held(const Scene& scene, const BodyConfig& body, std::vector<std::string>& warnings) {
  const auto& [holds, loads] = std::tie(scene.environment.holds, scene.environment.loads);
  for (std::size_t l = 0; l < loads.size(); ++l)
    for (std::size_t h = 0; h < holds.size(); ++h) {
      if (loads[l].surface || holds[h].surface) continue;
      bool is_along = false;
      for (int axis = 0; axis < 3; ++axis)
        is_along |= loads[l].force[axis] != 0 && holds[h].axes[std::size_t(axis)];
      if (!is_along) continue;
      bool in_vain = false;
      for_each_corner_in(loads[l].box, holds[h].box, body, [&](const Vec3&) { in_vain = true; });
      if (in_vain)
        warnings.push_back(
            fmt::format("load.{} acts on particles that hold.{} holds along it: there it "
                        "changes the hold's force and nothing else",
                        l, h));
    }
}

/// A hold whose box ends where the bounding box of the mesh does, and so leaves out particles of cells that
/// reach past it. Where it holds none of this body it may be meant for another, and nothing is said.
void add_holds_short_of_particles(const Scene& scene, const SceneBody& one,
                                  std::vector<std::string>& warnings) {
  if (!one.mesh) return;
  const double h = one.body.cell_size;
  const Box mesh = bounding_box(one.mesh->surface());
  for (std::size_t i = 0; i < scene.environment.holds.size(); ++i) {
    const Hold& hold = scene.environment.holds[i];
    if (hold.surface) continue;
    Box past = hold.box;  // a cell longer wherever it reaches the mesh's end
    for (int axis = 0; axis < 3; ++axis) {
      if (hold.box.lower[axis] < mesh.lower[axis] + 0.01 * h) past.lower[axis] -= h;
      if (hold.box.upper[axis] > mesh.upper[axis] - 0.01 * h) past.upper[axis] += h;
    }
    bool holds = false, leaves_out = false;
    for_each_corner_in(past, past, one.body,
                       [&](const Vec3& x) { (contains(hold.box, x, 1e-9 * h) ? holds : leaves_out) = true; });
    if (holds && leaves_out)
      warnings.push_back(fmt::format(
          "hold.{}: its box ends where the mesh does, and does not hold particles up to a cell outside "
          "the mesh; make it a cell longer there, or give surface_box (in a scene of one [body])",
          i));
  }
}

/// A body that nothing can stop: gravity takes it along or away from every plane.
void add_endless_fall(const Scene& scene, std::vector<std::string>& warnings) {
  const auto& [gravity, holds, planes] =
      std::tie(scene.environment.gravity, scene.environment.holds, scene.environment.planes);
  if (gravity.isZero(0) || !holds.empty() || planes.empty() || !scene.environment.obstacles.empty()) return;
  if (std::none_of(planes.begin(), planes.end(),
                   [&](const Plane& plane) { return plane.normal.dot(gravity) < -1e-9 * gravity.norm(); }))
    warnings.emplace_back(
        "no plane is below the body: gravity takes it along or away from all of them, so it falls for ever; "
        "give a plane whose normal points against gravity");
}

/// Of the cells' parts, each as far as it fills them [kg].
double full_mass(const BodyConfig& body) {
  const std::vector<Part> parts = body.all_parts();
  double mass = 0;
  body.voxels.for_each_place([&](int i, int j, int k) {
    if (!body.voxels.at(i, j, k)) return;
    if (body.content_of.empty())
      mass += body.density;
    else
      for (const auto& [part, fill] : body.contents[body.content_of[body.voxels.index(i, j, k)]])
        mass += double(fill.share()) * parts[std::size_t(part)].density;
  });
  return mass * body.cell_volume();
}

/// Sizes and masses that nobody simulates in metres and kilograms, and many in other units.
void add_other_units(const SceneBody& scene, std::vector<std::string>& warnings) {
  constexpr double largest = 50, smallest = 1e-3;  // [m]
  const VoxelGrid& cells = scene.body.voxels;
  const double extent = scene.body.cell_size * std::max({cells.nx(), cells.ny(), cells.nz()});
  if (extent > largest)
    warnings.push_back(fmt::format(
        "the body is {:.3g} m long: scenes are in metres, kilograms and seconds; if it was meant in "
        "millimetres, give {} a thousandth of it",
        extent, scene.mesh ? "body.mesh_scale" : "body.cell_size"));
  if (extent < smallest)
    warnings.push_back(
        fmt::format("the body is {:.3g} m long: scenes are in metres, kilograms and seconds, and so small a "
                    "body takes very short steps; if it was meant larger, give {} accordingly",
                    extent, scene.mesh ? "body.mesh_scale" : "body.cell_size"));
  constexpr double heaviest = 1e6;  // [kg]
  const double mass = full_mass(scene.body);
  if (mass > heaviest && extent <= largest)
    warnings.push_back(fmt::format(
        "the body has some {:.3g} kg: scenes are in metres, kilograms and seconds; if material.density "
        "was meant in other units, give it in kg/m^3",
        mass));
}

/// What is there and does nothing, or not what it is meant for.
void add_without_effect(const Scene& scene, std::vector<std::string>& warnings) {
  const auto& [strikes, planes] = std::tie(scene.environment.strikes, scene.environment.planes);
  for (std::size_t i = 0; i < strikes.size(); ++i)
    if (strikes[i].at > scene.solve.duration)
      warnings.push_back(fmt::format("strike.{}.at = {:.6g} s is after the end: solve.duration = {:.6g} s", i,
                                     strikes[i].at, scene.solve.duration));
  for (std::size_t i = 0; i < planes.size(); ++i)
    add_restitution(scene, planes[i], fmt::format("plane.{}", i), warnings);
  const std::vector<Obstacle>& obstacles = scene.environment.obstacles;
  for (std::size_t i = 0; i < obstacles.size(); ++i)
    add_restitution(scene, obstacles[i], fmt::format("obstacle.{}", i), warnings);
  add_endless_fall(scene, warnings);
}

/// What only bodies of springs have. The constants assume the full, weighted lattice.
void add_springs(const SceneBody& scene, std::vector<std::string>& warnings) {
  const BodyConfig& body = scene.body;
  if (!body.is_solid()) {
    if (body.voxels.dimensions() == 2 && body.springs.face == 0)
      warnings.emplace_back("squares without face diagonals do not resist shear; give material.springs.face");
    return;
  }
  if (body.topology != Topology::full) {
    warnings.push_back(
        fmt::format("body.topology = \"{}\" leaves out face diagonals: the body is softer in shear than its "
                    "material, and anisotropic",
                    to_string(body.topology)));
    return;
  }
  for (std::string& warning : material_warnings(body.springs, body.cell_size))
    warnings.push_back(std::move(warning));
  for (const Part& part : body.parts)
    for (const std::string& warning : material_warnings(part.springs, body.cell_size))
      warnings.push_back(fmt::format("part \"{}\": {}", part.name, warning));
  add_contrasts(body, warnings);
  if (body.sharing == Sharing::uniform && body.elastic)
    warnings.emplace_back(
        "body.sharing = \"uniform\" makes surfaces stiffer than material.young; only "
        "\"weighted\" keeps it");
}

std::vector<std::string> warnings_of_body(const Scene& scene, const SceneBody& one) {
  std::vector<std::string> warnings;
  const std::size_t planes = scene.environment.planes.size();
  add_meshes(one, planes > 0 || !scene.environment.obstacles.empty(), warnings);
  add_other_units(one, warnings);
  for (std::size_t p = 0; p < planes; ++p) add_start_behind(scene, one, p, warnings);
  add_obstacles(scene, one, warnings);
  add_contradictions(scene, one.body, warnings);
  add_loads_on_held(scene, one.body, warnings);
  add_holds_short_of_particles(scene, one, warnings);
  if (has_springs(one.model)) add_springs(one, warnings);
  return warnings;
}

/// Whether cells face each other across a gap along an axis: as of a ring, an arch, or legs.
bool faces_itself(const VoxelGrid& voxels) {
  const std::array<int, 3> size = voxels.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t second = (axis + 1) % 3, third = (axis + 2) % 3;
    std::array<int, 3> at{};
    for (at[second] = 0; at[second] < std::max(1, size[second]); ++at[second])
      for (at[third] = 0; at[third] < std::max(1, size[third]); ++at[third]) {
        bool was_filled = false, has_gap = false;
        for (at[axis] = 0; at[axis] < size[axis]; ++at[axis]) {
          const bool is_filled = voxels.at(at[0], at[1], at[2]);
          if (is_filled && has_gap) return true;
          has_gap |= was_filled && !is_filled;
          was_filled |= is_filled;
        }
      }
  }
  return false;
}

/// Bodies, or parts of one, that go through each other.
void add_missing_contact(const Scene& scene, std::vector<std::string>& warnings) {
  if (scene.states_contact) return;
  if (!scene.others.empty())
    warnings.emplace_back(
        "bodies do not touch each other: they go through each other without a force; give [contact] with "
        "bodies = true, or false if that is meant");
  const std::vector<const SceneBody*> bodies = bodies_of(scene);
  if (std::any_of(bodies.begin(), bodies.end(),
                  [](const SceneBody* one) { return faces_itself(one->body.voxels); }))
    warnings.emplace_back(
        "the body has parts that face each other across a gap, and they would go through each other without "
        "a force; give [contact] with self = true, or false if they stay apart");
}

}  // namespace

std::vector<std::string> scene_warnings(const Scene& scene) {
  std::vector<std::string> warnings;
  const std::vector<const SceneBody*> bodies = bodies_of(scene);
  for (std::size_t b = 0; b < bodies.size(); ++b)
    for (const std::string& warning : warnings_of_body(scene, *bodies[b]))
      warnings.push_back(scene.others.empty() ? warning : fmt::format("body.{}: {}", b, warning));
  add_without_effect(scene, warnings);
  add_missing_contact(scene, warnings);
  return warnings;
}

}  // namespace mss
