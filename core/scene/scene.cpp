#include "core/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.hpp"
#include "core/bodies/bodies_measures.hpp"
#include "core/measures/reactions.hpp"
#include "core/mesh/closed_surface.hpp"
#include "core/mesh/read_mesh.hpp"
#include "core/mesh/shapes.hpp"
#include "core/refinement/refined_system.hpp"
#include "core/scene/allowed.hpp"
#include "core/scene/scene_body_reader.hpp"
#include "core/scene/scene_boxes.hpp"
#include "core/scene/scene_keys.hpp"
#include "core/scene/toml_reader.hpp"

namespace mss {

namespace {

using namespace allowed;

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
  read_keys(contact_keys(), scene.table("contact"), environment.contact);
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

bool any_touches_by_mesh(const Scene& scene) {
  const std::vector<const SceneBody*> bodies = bodies_of(scene);
  return std::any_of(bodies.begin(), bodies.end(),
                     [](const SceneBody* one) { return one->contact_surface != nullptr; });
}

/// What planes touch: the particles, or the surface of the mesh.
void check_contact_surface(const TomlTable& root, const Scene& scene) {
  if (!any_touches_by_mesh(scene)) return;
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
    if (any_touches_by_mesh(scene) && scene.environment.obstacles.back().contact == ContactLaw::thesis)
      table.reject("contact",
                   "is a law of particles, and body.contact_on is \"surface\"; give \"impulse\" or "
                   "\"penalty\"");
  }
}

/// Adds the columns of holds, planes, obstacles, bodies and contact among the keys of [expect].
void add_expected_columns(const TomlTable& expect, const Scene& scene, std::vector<std::string>& quantities) {
  const Environment& environment = scene.environment;
  const Reactions reactions{.holds = std::vector<Vec3>(environment.holds.size(), Vec3::Zero()),
                            .planes = std::vector<Vec3>(environment.planes.size(), Vec3::Zero()),
                            .obstacles = std::vector<Vec3>(environment.obstacles.size(), Vec3::Zero()),
                            .torques = std::vector<Vec3>(environment.obstacles.size(), Vec3::Zero())};
  std::vector<std::string> columns;
  for_each_component(reactions, [&](const std::string& name, double) { columns.push_back(name); });
  BodiesMeasures measures;
  if (!scene.others.empty()) measures.bodies.resize(scene.others.size() + 1);
  if (environment.contact.acts()) measures.contact.emplace();
  for_each_column(measures, [&](const std::string& name, const char*, double) { columns.push_back(name); });
  const std::vector<std::string> others = quantities;
  for (const std::string& key : expect.keys()) {
    if (std::find(others.begin(), others.end(), key) != others.end()) continue;
    if (std::find(columns.begin(), columns.end(), key) == columns.end())
      expect.reject(key, fmt::format("is of none of the scene's {} holds, {} planes, {} obstacles and {} "
                                     "bodies; count them from 0",
                                     environment.holds.size(), environment.planes.size(),
                                     environment.obstacles.size(), scene.others.size() + 1));
    quantities.push_back(key);
  }
}

std::vector<Expectation> read_expectations(const TomlTable& expect, const Scene& scene,
                                           const TriangleMesh* surface) {
  std::vector<std::string> quantities = scene_keys().at("expect");
  std::erase_if(quantities, [&](const std::string& quantity) {
    return !expect.has(quantity) || quantity.find('#') != std::string::npos;
  });
  add_expected_columns(expect, scene, quantities);
  std::vector<Expectation> all;
  for (const std::string& quantity : quantities) {
    const TomlTable table = expect.table(quantity);
    Expectation e{.quantity = quantity, .within = table.number("within", margin)};
    if (quantity == mean_displacement) {
      const Vec3 value = table.vector("value", displacement);
      e.value = {value[0], value[1], value[2]};
      const auto [box, on_surface] = read_some_box(table, surface, scene.body.cell_size);
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

std::vector<const SceneBody*> bodies_of(const Scene& scene) {
  std::vector<const SceneBody*> bodies{&scene};
  for (const SceneBody& other : scene.others) bodies.push_back(&other);
  return bodies;
}

Box box_at_rest(const Scene& scene) {
  Box box{scene.body.origin, scene.body.origin};
  for (const SceneBody* one : bodies_of(scene)) {
    const BodyConfig& body = one->body;
    const Vec3 upper =
        body.origin + body.cell_size * Vec3(body.voxels.nx(), body.voxels.ny(), body.voxels.nz());
    box = {box.lower.cwiseMin(body.origin), box.upper.cwiseMax(upper)};
  }
  return box;
}

std::unique_ptr<const RefinedBody> refined_body(const Scene& scene) {
  if (scene.auto_refinement)
    throw InputError(fmt::format(
        "{}: body.refinement = \"auto\" has cells chosen by a solution at rest, which is not known here",
        scene.file.string()));
  if (scene.refined_boxes.empty()) return nullptr;
  return std::make_unique<const RefinedBody>(scene.body, refinement_of(scene.body, scene.refined_boxes));
}

namespace {

/// What a scene of several bodies has not: keys of one body, and those whose place is below a [[body]].
void check_several(const TomlTable& root, const std::vector<BodyTables>& tables) {
  if (!root.is_array("body")) return;
  for (const char* key : {"part", "weight"})
    if (!root.tables(key).empty())
      root.tables(key).front().reject(
          "name", fmt::format("is of none of the bodies; write [[body.{}]] below its [[body]]", key));
  const auto refuse = [](const TomlTable& table, const char* key) {
    if (table.has(key))
      table.reject(key, "is for a scene of one [body], and this has [[body]]; leave it out");
  };
  for (const BodyTables& one : tables) {
    for (const char* key : {"refinement", "match", "match_to"}) refuse(one.body, key);
    refuse(one.material, "modes");
  }
  for (const TomlTable& table : root.tables("refine")) refuse(table, "box");
  for (const char* array : {"hold", "load"})
    for (const TomlTable& table : root.tables(array)) refuse(table, "surface_box");
  refuse(root.table("expect").table(mean_displacement), "surface_box");
}

/// [expect] and [[refine]] of a body without cells of three dimensions.
void check_flat(const TomlTable& root, const Scene& scene) {
  const auto bodies = bodies_of(scene);
  if (std::any_of(bodies.begin(), bodies.end(), [](const SceneBody* b) { return b->body.is_solid(); }))
    return;
  if (!root.tables("refine").empty()) refuse_of_cells(root.tables("refine").front(), {"box"}, scene.body);
  refuse_of_cells(root.table("expect"), {"volume_ratio", "volume_ratio_paper", "min_jacobian"}, scene.body);
}

/// Bodies have names of their own.
void check_names(const Scene& scene, const std::vector<BodyTables>& tables) {
  const auto bodies = bodies_of(scene);
  for (std::size_t b = 1; b < bodies.size(); ++b)
    for (std::size_t a = 0; a < b; ++a)
      if (!bodies[b]->body_name.empty() && bodies[a]->body_name == bodies[b]->body_name)
        tables[b].body.reject("name", "is the name of another body; give each its own");
}

void read_bodies(const TomlTable& root, Scene& scene) {
  const std::vector<BodyTables> tables = body_tables(root);
  check_several(root, tables);
  const std::filesystem::path folder = scene.file.parent_path();
  static_cast<SceneBody&>(scene) = read_scene_body(tables.front(), folder, scene.warnings);
  for (std::size_t i = 1; i < tables.size(); ++i)
    scene.others.push_back(read_scene_body(tables[i], folder, scene.warnings));
  check_names(scene, tables);
  check_flat(root, scene);
}

Scene scene_of(const TomlFile& toml) {
  const TomlTable root(toml);
  Scene scene;
  scene.file = toml.file();
  scene.name = toml.file().stem().string();
  read_bodies(root, scene);
  if (const TomlTable material = root.table("material"); material.has("modes"))
    scene.modes = material.whole("modes", mode_count, 0);
  const double cell_size = scene.body.cell_size;
  const std::shared_ptr<const TriangleMesh> surface =
      scene.mesh ? std::make_shared<TriangleMesh>(scene.mesh->surface()) : nullptr;
  scene.environment = read_environment(root, surface, cell_size);
  scene.environment.contact_surface = scene.contact_surface;
  scene.states_contact = root.has("contact");
  read_keys(solve_keys(), root.table("solve"), scene.solve);
  check_contact_surface(root, scene);
  read_obstacles(root, scene);
  scene.expectations = read_expectations(root.table("expect"), scene, surface.get());
  if (!root.is_array("body")) {
    read_match(root, scene);
    read_refinement(root, scene);
  }
  find_empty_boxes(scene, [&](const PlaceOfBox& place, const std::string& complaint) {
    const std::vector<TomlTable> tables =
        place.body ? body_tables(root)[*place.body].weights : root.tables(place.table);
    tables[place.index].reject("box", complaint);
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
