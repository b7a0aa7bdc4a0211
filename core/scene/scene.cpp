#include "core/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.hpp"
#include "core/measures/reactions.hpp"
#include "core/mesh/closed_surface.hpp"
#include "core/mesh/read_mesh.hpp"
#include "core/mesh/shapes.hpp"
#include "core/refinement/refined_system.hpp"
#include "core/scene/allowed.hpp"
#include "core/scene/scene_boxes.hpp"
#include "core/scene/scene_keys.hpp"
#include "core/scene/toml_reader.hpp"

namespace mss {

namespace {

using namespace allowed;

void check_size(const TomlTable& body, std::string_view key, const std::array<int, 3>& cells, int refine) {
  double sites = 1;
  for (const int count : cells) sites *= double(count) * refine + 1;
  if (sites > most_sites())
    body.reject(
        key,
        fmt::format("makes a lattice of {:.0f} million particles; give fewer cells, at most {:.0f} million "
                    "particles fit",
                    sites / 1e6, most_sites() / 1e6));
}

std::vector<std::string> read_part_names(const TomlTable& root) {
  std::vector<std::string> names;
  for (const TomlTable& part : root.tables("part")) {
    const std::string name = part.text("name", "the name of a part",
                                       "a letter from A to Z, which its cells in the voxel file have");
    if (std::find(names.begin(), names.end(), name) != names.end())
      part.reject("name", "is the name of another part; give each its own");
    names.push_back(name);
  }
  return names;
}

/// A part without cells would silently have no effect.
void check_use(const TomlTable& root, const BodyConfig& config) {
  std::vector<bool> used(root.tables("part").size() + 1);
  for (const CellContent& content : config.contents)
    for (const PartFill& fill : content) used[std::size_t(fill.part)] = true;
  for (std::size_t part = 1; part < used.size(); ++part) {
    if (used[part]) continue;
    const TomlTable table = root.tables("part")[part - 1];
    constexpr auto remedy = "give body.voxels a file with cells of that letter, or leave the part out";
    if (!table.has("name")) table.reject_missing("name", remedy);
    table.reject("name", fmt::format("names a part that no cell uses; {}", remedy));
  }
}

/// Parts of a mesh are meshes too.
void read_mesh_cells(const TomlTable& root, Scene& scene) {
  const TomlTable body = root.table("body");
  const std::vector<TomlTable> parts = root.tables("part");
  for (const TomlTable& part : parts)
    if (!part.has("mesh"))
      part.reject_missing("mesh", "give the mesh that the part fills, as the body is one: its file");
  scene.mesh = read_scene_mesh(body, parts, scene.file.parent_path());
  scene.mesh->config.cell_size /= scene.refine;
  try {
    fill_cells(*scene.mesh, scene.body);
  } catch (const InputError& error) {
    body.reject("mesh", fmt::format("does not give a body: {}", error.what()));
  }
}

void read_cells(const TomlTable& root, Scene& scene) {
  const TomlTable body = root.table("body");
  BodyConfig& config = scene.body;
  if (body.has("mesh")) return read_mesh_cells(root, scene);
  for (const char* key :
       {"cells_across", "mesh_scale", "mesh_rotation", "mesh_translation", "fill", "contact_on"})
    if (body.has(key)) body.reject(key, "is about a mesh; give body.mesh, or leave it out");
  if (body.has("cells") && body.has("voxels"))
    body.reject("voxels", "conflicts with body.cells; give one of the two");
  if (!body.has("voxels")) {
    auto cells = body.three_whole("cells", cell_counts);
    if (cells == std::array{0, 0, 0}) body.reject("cells", "has no cell; give at least one along some axis");
    check_size(body, "cells", cells, scene.refine);
    config.voxels = VoxelGrid::box(cells[0], cells[1], cells[2]);
  } else {
    const std::vector<std::string> parts = read_part_names(root);
    scene.voxel_file =
        body.text("voxels", "a file name", "the path of a voxel file, relative to the scene file");
    try {
      VoxelFile file = read_voxels(scene.file.parent_path() / scene.voxel_file, parts);
      check_size(body, "voxels", file.voxels.size(), scene.refine);
      config.voxels = std::move(file.voxels);
      config.contents = std::move(file.contents);
      config.content_of = std::move(file.content_of);
    } catch (const InputError& error) {
      body.reject("voxels", fmt::format("does not give a body: {}", error.what()));
    }
  }
  check_use(root, config);
  resample(config, 1, scene.refine);
}

/// What a sheet or a rope is across, after its cells.
void read_thickness(const TomlTable& body, Scene& scene) {
  constexpr auto key = "thickness";
  BodyConfig& config = scene.body;
  if (config.is_solid()) {
    if (body.has(key))
      body.reject(key,
                  "is of a sheet or a rope, and this body has cells along all axes; leave it out, or give "
                  "body.cells a 0");
    return;
  }
  const double cell_size = config.cell_size * scene.refine;
  config.thickness = body.number(key, length, cell_size);
  if (!body.has(key))
    scene.warnings.push_back(
        fmt::format("body.thickness is missing and taken as body.cell_size, {:.6g} m: {} in smaller cells "
                    "would be thinner, lighter and softer; give it",
                    cell_size, config.noun()));
}

bool have_finite_moduli(const SpringConstants& springs, double cell_size) {
  const CubicStiffness moduli = cubic_stiffness(springs, cell_size);
  return std::isfinite(springs.edge + springs.volume + moduli.c11 + moduli.c12 + moduli.c44);
}

SpringConstants calibrate_for(const Scene& scene, const ElasticConstants& elastic, const TomlTable& table) {
  SpringConstants springs = scene.body.calibrated(elastic, scene.face_share);
  if (!scene.volume_force) springs.volume = 0;
  if (!have_finite_moduli(springs, scene.body.cell_size))
    table.reject("young", "is too large to compute with; give a smaller number of pascals");
  return springs;
}

/// Keys of cells of three dimensions.
void refuse_of_cells(const TomlTable& table, std::initializer_list<const char*> keys,
                     const BodyConfig& config) {
  for (const char* key : keys)
    if (table.has(key))
      table.reject(key, fmt::format("is of cells of three dimensions, and this body is {}; leave it out",
                                    config.noun()));
}

/// What squares and links have not: it may be said that there is none of it.
void check_flat(const TomlTable& root, const BodyConfig& config) {
  const TomlTable body = root.table("body"), material = root.table("material");
  refuse_of_cells(body, {"refinement", "match", "match_to"}, config);
  refuse_of_cells(material, {"face_share", "volume_force"}, config);
  if (!root.tables("refine").empty()) refuse_of_cells(root.tables("refine").front(), {"box"}, config);
  refuse_of_cells(root.table("expect"), {"volume_ratio", "volume_ratio_paper", "min_jacobian"}, config);
  if (config.topology != Topology::full) refuse_of_cells(body, {"topology"}, config);
  if (config.sharing != Sharing::weighted) refuse_of_cells(body, {"sharing"}, config);
  if (config.fold_guard != 0) refuse_of_cells(material, {"fold_guard"}, config);
  if (config.springs.volume != 0) refuse_of_cells(material, {"volume"}, config);
  if (config.springs.body != 0) refuse_of_cells(material.table("springs"), {"body"}, config);
  if (config.springs.face != 0 && config.voxels.dimensions() == 1)
    material.table("springs").reject("face", "is across squares, and a rope has none; leave it out");
}

SpringConstants read_given_springs(const TomlTable& material, const Scene& scene) {
  const TomlTable springs = material.table("springs");
  const int dimensions = scene.body.voxels.dimensions();
  return {.edge = springs.number("edge", spring),
          .face = dimensions < 2 ? springs.number("face", spring, 0) : springs.number("face", spring),
          .body = dimensions < 3 ? springs.number("body", spring, 0) : springs.number("body", spring),
          .volume = material.number("volume", volume, 0)};
}

/// Of sheets and ropes springs determine nu: a sheet's is 1/3, and a rope has none.
ElasticConstants read_elastic(const TomlTable& material, Scene& scene) {
  const double modulus = material.number("young", young);
  if (scene.body.is_solid()) return {.young = modulus, .poisson = material.number("poisson", poisson)};
  constexpr double of_sheets = 1.0 / 3, rounded = 0.005;
  const double given = material.number("poisson", poisson, of_sheets);
  if (std::abs(given - of_sheets) > rounded)
    scene.warnings.push_back(
        scene.body.voxels.dimensions() == 1
            ? fmt::format("material.poisson = {} is not used: a rope has no width that could change", given)
            : fmt::format("material.poisson = {} is not used: springs of a sheet make it 1/3", given));
  return {.young = modulus, .poisson = of_sheets};
}

/// Springs as given, or calibrated for the elastic constants given, which are kept.
SpringConstants read_springs(const TomlTable& material, Scene& scene) {
  const bool calibrated = material.has("young") || material.has("poisson");
  if (material.has("springs")) {
    for (const auto* key : {"young", "poisson", "face_share", "volume_force"})
      if (material.has(key)) material.reject(key, "conflicts with material.springs; give one of the two");
    const SpringConstants given = read_given_springs(material, scene);
    if (!have_finite_moduli(given, scene.body.cell_size))
      material.reject("springs", "are too stiff to compute with; give smaller constants");
    return given;
  }
  if (!calibrated)
    material.reject_missing("young",
                            "give young and poisson, or springs = { edge = .., face = .., body = .. }");
  if (material.has("volume"))
    material.reject("volume", "conflicts with material.young, which determines it; give one of the two");
  scene.body.elastic = read_elastic(material, scene);
  scene.face_share = material.number("face_share", share, scene.face_share);
  scene.volume_force = material.boolean("volume_force", scene.volume_force);
  return calibrate_for(scene, *scene.body.elastic, material);
}

/// `shear_modulus` of the springs.
Damping read_damping(const TomlTable& damping, double shear_modulus) {
  const bool thesis = damping.boolean("thesis", false);
  for (const char* other : {"ratio", "viscosity"})
    if (thesis && damping.has(other))
      damping.reject(other,
                     fmt::format("conflicts with {}.thesis = true; give one of the two", damping.path()));
  if (damping.has("ratio") && damping.has("viscosity"))
    damping.reject("viscosity", fmt::format("conflicts with {}.ratio; give one of the two", damping.path()));
  if (thesis) return {.law = Damping::Law::thesis};
  if (const double zeta = damping.number("ratio", damping_ratio, 0); zeta > 0)
    return {.law = Damping::Law::ratio, .zeta = zeta};
  const double eta = damping.number("viscosity", viscosity, 0);
  if (eta == 0) return {};
  if (shear_modulus == 0)
    damping.reject("viscosity",
                   "is of shear, which these springs do not resist; give face or body diagonals");
  return {.law = Damping::Law::viscosity, .viscosity = eta};
}

double read_fold_guard(const TomlTable& material, const BodyConfig& config) {
  const double stiffness = material.number("fold_guard", guard, 0);
  if (stiffness > 0 && config.shear_modulus() == 0)
    material.reject("fold_guard",
                    "is in shear moduli, and these springs have none; give face or body diagonals");
  return stiffness;
}

Relaxation read_relaxation(const TomlTable& material, const Scene& scene) {
  constexpr auto key = "relaxation";
  if (!material.has(key)) return {};
  if (scene.model != spring_model)
    material.reject(key,
                    fmt::format("is of springs, and material.model is \"{}\"; leave it out", scene.model));
  const TomlTable table = material.table(key);
  const Relaxation relaxation{.ratio = table.number("ratio", relaxation_ratio),
                              .time = table.number("time", relaxation_time)};
  if (!std::isnormal(1 / relaxation.time))
    table.reject("time", "is too short to compute with; leave relaxation out, or give more seconds");
  return relaxation;
}

/// Rejects what makes particles too light to compute with; `other` is the key that might be changed instead.
void check_mass(const TomlTable& table, const char* key, double of_cell, const char* other) {
  if (!std::isnormal(of_cell / 8))
    table.reject(key, fmt::format("gives particles of mass {} kg; change it or {}", of_cell / 8, other));
}

/// What a part does not say is [material]'s and [damping]'s.
Part read_part(const TomlTable& table, const Scene& scene) {
  const BodyConfig& config = scene.body;
  Part part = config.all_parts().front();
  part.name = table.text("name", "a name", "a text");
  part.density = table.number("density", density, part.density);
  check_mass(table, "density", part.density * std::pow(config.cell_size, 3), "body.cell_size");
  if (table.has("young") || table.has("poisson")) {
    const auto number = [&](const char* key, const Quantity& quantity, double ElasticConstants::*of) {
      return part.elastic ? table.number(key, quantity, *part.elastic.*of) : table.number(key, quantity);
    };
    part.elastic = {.young = number("young", young, &ElasticConstants::young),
                    .poisson = number("poisson", poisson, &ElasticConstants::poisson)};
    part.springs = calibrate_for(scene, *part.elastic, table);
  }
  if (table.has("damping"))
    part.damping = read_damping(table.table("damping"), config.shear_modulus_of(part.springs));
  return part;
}

void read_body(const TomlTable& root, Scene& scene) {
  const TomlTable body = root.table("body");
  const TomlTable material = root.table("material");
  BodyConfig& config = scene.body;
  scene.refine = body.whole("refine", split_parts, scene.refine);
  read_cells(root, scene);
  if (!scene.mesh) {
    config.cell_size = body.number("cell_size", length) / scene.refine;
    config.origin = body.vector("origin", position, Vec3::Zero());
  }
  read_thickness(body, scene);
  config.topology = body.choice("topology", "a topology", topologies, Topology::full);
  config.sharing = body.choice("sharing", "a way of sharing springs", sharings, Sharing::weighted);
  if (config.sharing != Sharing::weighted && !config.content_of.empty())
    body.reject("sharing", "is for full cells of one part; leave it out, or give \"weighted\"");
  config.density = material.number("density", density);
  check_mass(body,
             body.has("cells_across") ? "cells_across"
             : body.has("thickness")  ? "thickness"
                                      : "cell_size",
             config.density * config.cell_volume(), "material.density");
  config.springs = read_springs(material, scene);
  config.fold_guard = read_fold_guard(material, config);
  if (!config.is_solid()) check_flat(root, config);
  config.relaxation = read_relaxation(material, scene);
  config.damping = read_damping(root.table("damping"), config.shear_modulus());
  for (const TomlTable& table : root.tables("part")) config.parts.push_back(read_part(table, scene));
  for (const TomlTable& table : root.tables("weight"))
    read_keys(weight_keys(), table, config.weights.emplace_back());
}

/// A box of particles, `box`, or of vertices of the mesh, `surface_box`.
struct SomeBox {
  Box box;
  bool on_surface = false;
};
SomeBox read_some_box(const TomlTable& table, const TriangleMesh* surface, double cell_size) {
  constexpr auto key = "surface_box";
  if (!table.has(key)) return {table.box("box")};
  if (table.has("box"))
    table.reject(key, fmt::format("conflicts with {}.box; give one of the two", table.path()));
  if (!surface) table.reject(key, "is about a mesh; give body.mesh, or box in its place");
  SomeBox read{table.box(key), true};
  if (!vertices_in(*surface, read.box, 1e-9 * cell_size).empty()) return read;
  const auto [lower, upper] = bounding_box(*surface);
  table.reject(key, fmt::format("contains no vertex of the mesh; give one that does, it spans "
                                "[{:.6g}, {:.6g}, {:.6g}] to [{:.6g}, {:.6g}, {:.6g}]",
                                lower[0], lower[1], lower[2], upper[0], upper[1], upper[2]));
}

Hold read_hold(const TomlTable& table, const std::shared_ptr<const TriangleMesh>& surface, double cell_size) {
  const auto [box, on_surface] = read_some_box(table, surface.get(), cell_size);
  if (on_surface && faces_in(*surface, box, 1e-9 * cell_size).empty())
    table.reject("surface_box", "contains no whole face of the mesh; give one that does");
  Hold hold{.box = box, .turn = {}, .surface = on_surface ? surface : nullptr};
  read_keys(hold_keys(), table, hold);
  if (table.has("turn")) read_keys(turn_keys(), table.table("turn"), hold.turn.emplace());
  return hold;
}

Load read_load(const TomlTable& table, const std::shared_ptr<const TriangleMesh>& surface, double cell_size) {
  const auto [box, on_surface] = read_some_box(table, surface.get(), cell_size);
  Load load{.box = box, .surface = on_surface ? surface : nullptr};
  read_keys(load_keys(), table, load);
  return load;
}

Environment read_environment(const TomlTable& scene, const std::shared_ptr<const TriangleMesh>& surface,
                             double cell_size) {
  Environment environment;
  read_keys(environment_keys(), scene.table("environment"), environment);
  for (const TomlTable& table : scene.tables("hold"))
    environment.holds.push_back(read_hold(table, surface, cell_size));
  for (const TomlTable& table : scene.tables("load"))
    environment.loads.push_back(read_load(table, surface, cell_size));
  for (const TomlTable& table : scene.tables("strike"))
    read_keys(strike_keys(), table, environment.strikes.emplace_back());
  for (const TomlTable& table : scene.tables("plane"))
    read_keys(plane_keys(), table, environment.planes.emplace_back());
  return environment;
}

/// What the body and its model have to be for cells to be split.
void check_splittable(const TomlTable& table, std::string_view key, const Scene& scene) {
  if (scene.mesh)
    table.reject(key,
                 "splits cells, and a mesh may fill these unevenly; give body.voxels or "
                 "body.cells, or a smaller body.cell_size");
  if (scene.body.relaxation.acts())
    table.reject(key,
                 "splits cells, and material.relaxation is for cells of one size; leave one of them out");
  if (scene.model != spring_model)
    table.reject(key, fmt::format("is for model \"{}\", and material.model is \"{}\"; leave it out",
                                  spring_model, scene.model));
}

/// Cells that are chosen later; whether they can be split is seen now.
void read_auto_refinement(const TomlTable& root, Scene& scene) {
  static const std::vector<std::pair<std::string, bool>> ways{{"auto", true}};
  const TomlTable body = root.table("body");
  if (!body.choice("refinement", "a way of choosing smaller cells", ways, false)) {
    for (const char* key : {"refinement_levels", "refinement_goal"})
      if (body.has(key)) body.reject(key, "is of body.refinement = \"auto\", which is missing; give both");
    return;
  }
  check_splittable(body, "refinement", scene);
  if (!root.tables("refine").empty())
    body.reject("refinement", "chooses cells, and [[refine]] does so too; leave one of them out");
  AutoRefinement& chosen = scene.auto_refinement.emplace();
  chosen.levels = body.whole("refinement_levels", split_levels, 1);
  chosen.goal = body.choice("refinement_goal", "a goal", refinement_goals, AutoRefinement::Goal::energy);
  if (chosen.goal == AutoRefinement::Goal::displacement && !root.table("expect").has(mean_displacement))
    body.reject("refinement_goal", "is the displacement of [expect], which is missing; give it");
  try {
    RefinedBody(scene.body, {});
  } catch (const InputError& error) {
    body.reject("refinement", fmt::format("does not give a body: {}", error.what()));
  }
}

/// Moduli that are changed later; whether they can be is seen now.
void read_match(const TomlTable& root, Scene& scene) {
  const TomlTable body = root.table("body");
  if (!body.has("match")) {
    if (body.has("match_to")) body.reject("match_to", "is of body.match, which is missing; give both");
    return;
  }
  if (!scene.body.elastic)
    body.reject("match",
                "changes E, and material.springs are given; give material.young and material.poisson");
  FrequencyMatch& match = scene.match.emplace();
  match.of = body.choice("match", "what is matched", frequency_matches, FrequencyMatch::Of::bending);
  match.parts = body.whole("match_to", matched_parts, 0);
}

/// Of the last box read.
int depth_of_refinement(const TomlTable& table, const Scene& scene) {
  try {
    return refinement_of(scene.body, {scene.refined_boxes.back()}).depth();
  } catch (const InputError& error) {
    table.reject("box", error.what());
  }
}

/// Where cells are split further; after everything that this may contradict.
void read_refinement(const TomlTable& root, Scene& scene) {
  read_auto_refinement(root, scene);
  const std::vector<TomlTable> tables = root.tables("refine");
  if (tables.empty()) return;
  check_splittable(tables.front(), "box", scene);
  for (const TomlTable& table : tables) {
    read_keys(refine_keys(), table, scene.refined_boxes.emplace_back());
    if (depth_of_refinement(table, scene) == 0)
      table.reject("box", fmt::format("contains no part of a cell; give one that does, {}",
                                      extent_at_rest(scene.body)));
  }
  try {
    const std::unique_ptr<const RefinedBody> body = refined_body(scene);
    check_holds(*body, HeldSites(body->levels(), scene.environment.holds));
  } catch (const InputError& error) {
    tables.front().reject("box", fmt::format("does not give a body: {}", error.what()));
  }
}

/// What planes touch: the particles, or the surface of the mesh.
void read_contact_surface(const TomlTable& root, const std::shared_ptr<const TriangleMesh>& surface,
                          Scene& scene) {
  static const std::vector<std::pair<std::string, bool>> touched{{"particles", false}, {"surface", true}};
  if (!root.table("body").choice("contact_on", "what planes touch", touched, false)) return;
  const std::vector<Plane>& planes = scene.environment.planes;
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (planes[i].contact == ContactLaw::thesis)
      root.tables("plane")[i].reject("contact",
                                     "is a law of particles, and body.contact_on is \"surface\"; give "
                                     "\"impulse\" or \"penalty\"");
  if (scene.solve.sleep.bound > 0)
    root.table("solve").reject("sleep",
                               "is for contact of particles, and body.contact_on is \"surface\"; leave one "
                               "of the two out");
  scene.environment.contact_surface = surface;
}

/// A mesh is turned to face outward.
Obstacle read_obstacle(const TomlTable& table, const std::filesystem::path& folder) {
  Obstacle obstacle;
  read_keys(obstacle_keys(), table, obstacle);
  if (table.has("turn")) read_keys(turn_keys(), table.table("turn"), obstacle.turn.emplace());
  if (obstacle.shape != ObstacleShape::mesh) return obstacle;
  try {
    TriangleMesh mesh = read_mesh(folder / obstacle.mesh_file).mesh;
    place(mesh, {.scale = obstacle.mesh_scale});
    if (enclosed_volume(mesh) < 0) mesh = turned_inside_out(mesh);
    obstacle.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
    ClosedSurface{*obstacle.mesh};
  } catch (const InputError& error) {
    table.reject("mesh", fmt::format("does not give an obstacle: {}", error.what()));
  }
  return obstacle;
}

void read_obstacles(const TomlTable& root, Scene& scene) {
  for (const TomlTable& table : root.tables("obstacle")) {
    scene.environment.obstacles.push_back(read_obstacle(table, scene.file.parent_path()));
    if (scene.environment.contact_surface && scene.environment.obstacles.back().contact == ContactLaw::thesis)
      table.reject("contact",
                   "is a law of particles, and body.contact_on is \"surface\"; give \"impulse\" or "
                   "\"penalty\"");
  }
}

/// Adds the forces of holds, planes and obstacles among the keys of [expect].
void add_expected_forces(const TomlTable& expect, const Environment& environment,
                         std::vector<std::string>& quantities) {
  const Reactions reactions{.holds = std::vector<Vec3>(environment.holds.size(), Vec3::Zero()),
                            .planes = std::vector<Vec3>(environment.planes.size(), Vec3::Zero()),
                            .obstacles = std::vector<Vec3>(environment.obstacles.size(), Vec3::Zero()),
                            .torques = std::vector<Vec3>(environment.obstacles.size(), Vec3::Zero())};
  std::vector<std::string> forces;
  for_each_component(reactions, [&](const std::string& name, double) { forces.push_back(name); });
  const std::vector<std::string> others = quantities;
  for (const std::string& key : expect.keys()) {
    if (std::find(others.begin(), others.end(), key) != others.end()) continue;
    if (std::find(forces.begin(), forces.end(), key) == forces.end())
      expect.reject(
          key,
          fmt::format("is of none of the scene's {} holds, {} planes and {} obstacles; count them from 0",
                      environment.holds.size(), environment.planes.size(), environment.obstacles.size()));
    quantities.push_back(key);
  }
}

std::vector<Expectation> read_expectations(const TomlTable& expect, const Environment& environment,
                                           const TriangleMesh* surface, double cell_size) {
  std::vector<std::string> quantities = scene_keys().at("expect");
  std::erase_if(quantities, [&](const std::string& quantity) {
    return !expect.has(quantity) || quantity.find('#') != std::string::npos;
  });
  add_expected_forces(expect, environment, quantities);
  std::vector<Expectation> all;
  for (const std::string& quantity : quantities) {
    const TomlTable table = expect.table(quantity);
    Expectation e{.quantity = quantity, .within = table.number("within", margin)};
    if (quantity == mean_displacement) {
      const Vec3 value = table.vector("value", displacement);
      e.value = {value[0], value[1], value[2]};
      const auto [box, on_surface] = read_some_box(table, surface, cell_size);
      e.box = box;
      e.on_surface = on_surface;
    } else {
      e.value = {table.number("value", expected)};
    }
    all.push_back(std::move(e));
  }
  return all;
}

}  // namespace

const std::string& to_string(ContactLaw law) { return name_of(law, contact_laws); }
const std::string& to_string(Topology topology) { return name_of(topology, topologies); }
const std::string& to_string(Sharing sharing) { return name_of(sharing, sharings); }
const std::string& to_string(Precision precision) { return name_of(precision, precisions); }
const std::string& to_string(Tangent tangent) { return name_of(tangent, tangents); }
const std::string& to_string(AutoRefinement::Goal goal) { return name_of(goal, refinement_goals); }
const std::string& to_string(FrequencyMatch::Of of) { return name_of(of, frequency_matches); }

std::unique_ptr<const RefinedBody> refined_body(const Scene& scene) {
  if (scene.auto_refinement)
    throw InputError(fmt::format(
        "{}: body.refinement = \"auto\" has cells chosen by a solution at rest, which is not known here",
        scene.file.string()));
  if (scene.refined_boxes.empty()) return nullptr;
  return std::make_unique<const RefinedBody>(scene.body, refinement_of(scene.body, scene.refined_boxes));
}

namespace {

Scene scene_of(const TomlFile& toml) {
  const TomlTable root(toml);
  Scene scene;
  scene.file = toml.file();
  scene.name = toml.file().stem().string();
  if (const TomlTable material = root.table("material"); material.has("model"))
    scene.model = material.text("model", "a model", "its name, such as \"springs\"");
  if (const TomlTable material = root.table("material"); material.has("modes"))
    scene.modes = material.whole("modes", mode_count, 0);
  read_body(root, scene);
  const double cell_size = scene.body.cell_size;
  const std::shared_ptr<const TriangleMesh> surface =
      scene.mesh ? std::make_shared<TriangleMesh>(scene.mesh->surface()) : nullptr;
  scene.environment = read_environment(root, surface, cell_size);
  read_keys(start_keys(), root.table("start"), scene);
  read_keys(solve_keys(), root.table("solve"), scene.solve);
  read_contact_surface(root, surface, scene);
  read_obstacles(root, scene);
  scene.expectations = read_expectations(root.table("expect"), scene.environment, surface.get(), cell_size);
  read_match(root, scene);
  read_refinement(root, scene);
  find_empty_boxes(scene, [&](std::string_view table, std::size_t index, const std::string& complaint) {
    root.tables(table)[index].reject("box", complaint);
  });
  for (const std::string& warning : scene_warnings(scene)) scene.warnings.push_back(printable(warning));
  return scene;
}

}  // namespace

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return scene_of(TomlFile(file, overrides, scene_keys(), renamed_scene_keys()));
}

Scene parse_scene(const std::string& toml, const std::vector<std::string>& overrides) {
  return scene_of(TomlFile(toml, "scene", overrides, scene_keys(), renamed_scene_keys()));
}

}  // namespace mss
