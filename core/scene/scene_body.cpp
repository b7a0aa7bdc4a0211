// What a scene file says of a body.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "core/base/error.hpp"
#include "core/base/limits.hpp"
#include "core/scene/allowed.hpp"
#include "core/scene/scene_body_reader.hpp"
#include "core/scene/scene_keys.hpp"

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

std::vector<std::string> read_part_names(const std::vector<TomlTable>& parts) {
  std::vector<std::string> names;
  for (const TomlTable& part : parts) {
    const std::string name = part.text("name", "the name of a part",
                                       "a letter from A to Z, which its cells in the voxel file have");
    if (std::find(names.begin(), names.end(), name) != names.end())
      part.reject("name", "is the name of another part; give each its own");
    names.push_back(name);
  }
  return names;
}

/// A part without cells would silently have no effect.
void check_use(const std::vector<TomlTable>& parts, const BodyConfig& config) {
  std::vector<bool> used(parts.size() + 1);
  for (const CellContent& content : config.contents)
    for (const PartFill& fill : content) used[std::size_t(fill.part)] = true;
  for (std::size_t part = 1; part < used.size(); ++part) {
    if (used[part]) continue;
    const TomlTable& table = parts[part - 1];
    constexpr auto remedy = "give body.voxels a file with cells of that letter, or leave the part out";
    if (!table.has("name")) table.reject_missing("name", remedy);
    table.reject("name", fmt::format("names a part that no cell uses; {}", remedy));
  }
}

/// Parts of a mesh are meshes too.
void read_mesh_cells(const BodyTables& tables, const std::filesystem::path& folder, SceneBody& scene) {
  const auto& [body, parts] = std::tie(tables.body, tables.parts);
  for (const TomlTable& part : parts)
    if (!part.has("mesh"))
      part.reject_missing("mesh", "give the mesh that the part fills, as the body is one: its file");
  scene.mesh = read_scene_mesh(body, parts, folder);
  scene.mesh->config.cell_size /= scene.refine;
  try {
    fill_cells(*scene.mesh, scene.body);
  } catch (const InputError& error) {
    body.reject("mesh", fmt::format("does not give a body: {}", error.what()));
  }
}

void read_cells(const BodyTables& tables, const std::filesystem::path& folder, SceneBody& scene) {
  const TomlTable& body = tables.body;
  BodyConfig& config = scene.body;
  if (body.has("mesh")) return read_mesh_cells(tables, folder, scene);
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
    const std::vector<std::string> parts = read_part_names(tables.parts);
    scene.voxel_file =
        body.text("voxels", "a file name", "the path of a voxel file, relative to the scene file");
    try {
      VoxelFile file = read_voxels(folder / scene.voxel_file, parts);
      check_size(body, "voxels", file.voxels.size(), scene.refine);
      config.voxels = std::move(file.voxels);
      config.contents = std::move(file.contents);
      config.content_of = std::move(file.content_of);
    } catch (const InputError& error) {
      body.reject("voxels", fmt::format("does not give a body: {}", error.what()));
    }
  }
  check_use(tables.parts, config);
  resample(config, 1, scene.refine);
}

/// What a sheet or a rope is across, after its cells.
void read_thickness(const TomlTable& body, SceneBody& scene, std::vector<std::string>& warnings) {
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
    warnings.push_back(
        fmt::format("{0}.thickness is missing and taken as {0}.cell_size, {1:.6g} m: {2} in smaller cells "
                    "would be thinner, lighter and softer; give it",
                    body.path(), cell_size, config.noun()));
}

bool have_finite_moduli(const SpringConstants& springs, double cell_size) {
  const CubicStiffness moduli = cubic_stiffness(springs, cell_size);
  return std::isfinite(springs.edge + springs.volume + moduli.c11 + moduli.c12 + moduli.c44);
}

SpringConstants calibrate_for(const SceneBody& scene, const ElasticConstants& elastic,
                              const TomlTable& table) {
  SpringConstants springs = scene.body.calibrated(elastic, scene.face_share);
  if (!scene.volume_force) springs.volume = 0;
  if (!have_finite_moduli(springs, scene.body.cell_size))
    table.reject("young", "is too large to compute with; give a smaller number of pascals");
  return springs;
}

}  // namespace

void refuse_of_cells(const TomlTable& table, std::initializer_list<const char*> keys,
                     const BodyConfig& config) {
  for (const char* key : keys)
    if (table.has(key))
      table.reject(key, fmt::format("is of cells of three dimensions, and this body is {}; leave it out",
                                    config.noun()));
}

namespace {

/// What squares and links have not: it may be said that there is none of it.
void check_flat(const BodyTables& tables, const BodyConfig& config) {
  const auto& [body, material] = std::tie(tables.body, tables.material);
  refuse_of_cells(body, {"refinement", "match", "match_to"}, config);
  refuse_of_cells(material, {"face_share", "volume_force"}, config);
  if (config.topology != Topology::full) refuse_of_cells(body, {"topology"}, config);
  if (config.sharing != Sharing::weighted) refuse_of_cells(body, {"sharing"}, config);
  if (config.fold_guard != 0) refuse_of_cells(material, {"fold_guard"}, config);
  if (config.springs.volume != 0) refuse_of_cells(material, {"volume"}, config);
  if (config.springs.body != 0) refuse_of_cells(material.table("springs"), {"body"}, config);
  if (config.springs.face != 0 && config.voxels.dimensions() == 1)
    material.table("springs").reject("face", "is across squares, and a rope has none; leave it out");
}

SpringConstants read_given_springs(const TomlTable& material, const SceneBody& scene) {
  const TomlTable springs = material.table("springs");
  const int dimensions = scene.body.voxels.dimensions();
  return {.edge = springs.number("edge", spring),
          .face = dimensions < 2 ? springs.number("face", spring, 0) : springs.number("face", spring),
          .body = dimensions < 3 ? springs.number("body", spring, 0) : springs.number("body", spring),
          .volume = material.number("volume", volume, 0)};
}

/// Of sheets and ropes springs determine nu: a sheet's is 1/3, and a rope has none.
ElasticConstants read_elastic(const TomlTable& material, SceneBody& scene,
                              std::vector<std::string>& warnings) {
  const double modulus = material.number("young", young);
  if (scene.body.is_solid()) return {.young = modulus, .poisson = material.number("poisson", poisson)};
  constexpr double of_sheets = 1.0 / 3, rounded = 0.005;
  const double given = material.number("poisson", poisson, of_sheets);
  if (std::abs(given - of_sheets) > rounded)
    warnings.push_back(
        scene.body.voxels.dimensions() == 1
            ? fmt::format("material.poisson = {} is not used: a rope has no width that could change", given)
            : fmt::format("material.poisson = {} is not used: springs of a sheet make it 1/3", given));
  return {.young = modulus, .poisson = of_sheets};
}

/// Springs as given, or calibrated for the elastic constants given, which are kept.
SpringConstants read_springs(const TomlTable& material, SceneBody& scene,
                             std::vector<std::string>& warnings) {
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
  scene.body.elastic = read_elastic(material, scene, warnings);
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

Relaxation read_relaxation(const TomlTable& material, const SceneBody& scene) {
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
Part read_part(const TomlTable& table, const SceneBody& scene) {
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

void read_material(const BodyTables& tables, SceneBody& scene, std::vector<std::string>& warnings) {
  const auto& [body, material] = std::tie(tables.body, tables.material);
  BodyConfig& config = scene.body;
  config.density = material.number("density", density);
  check_mass(body,
             body.has("cells_across") ? "cells_across"
             : body.has("thickness")  ? "thickness"
                                      : "cell_size",
             config.density * config.cell_volume(), "material.density");
  config.springs = read_springs(material, scene, warnings);
  config.fold_guard = read_fold_guard(material, config);
  if (!config.is_solid()) check_flat(tables, config);
  config.relaxation = read_relaxation(material, scene);
  config.damping = read_damping(tables.damping, config.shear_modulus());
  for (const TomlTable& table : tables.parts) config.parts.push_back(read_part(table, scene));
}

/// What a body says of its material stands for the scene's, key by key; springs for elastic constants, and
/// the other way round.
TomlTable material_of(const TomlTable& root, const TomlTable& body) {
  const TomlTable own = body.table("material"), scenes = root.table("material");
  if (own.has("springs"))
    return own.over(scenes, {"young", "poisson", "face_share", "volume_force", "volume"});
  if (own.has("young") || own.has("poisson")) return own.over(scenes, {"springs", "volume"});
  return own.over(scenes);
}

/// Of one of several bodies.
BodyTables tables_of_one(const TomlTable& root, const TomlTable& body) {
  return {body,
          material_of(root, body),
          body.has("damping") ? body.table("damping") : root.table("damping"),
          body.table("start").over(root.table("start")),
          body.tables("part"),
          body.tables("weight")};
}

/// What a mesh touches planes and other bodies by.
void read_contact_surface(const TomlTable& body, SceneBody& scene) {
  static const std::vector<std::pair<std::string, bool>> touched{{"particles", false}, {"surface", true}};
  if (body.choice("contact_on", "what planes touch", touched, false))
    scene.contact_surface = std::make_shared<TriangleMesh>(scene.mesh->surface());
}

}  // namespace

std::vector<BodyTables> body_tables(const TomlTable& root) {
  std::vector<BodyTables> all;
  if (!root.is_array("body"))
    all.push_back({root.table("body"), root.table("material"), root.table("damping"), root.table("start"),
                   root.tables("part"), root.tables("weight")});
  else
    for (const TomlTable& body : root.tables("body")) all.push_back(tables_of_one(root, body));
  return all;
}

SceneBody read_scene_body(const BodyTables& tables, const std::filesystem::path& folder,
                          std::vector<std::string>& warnings) {
  const auto& [body, material] = std::tie(tables.body, tables.material);
  SceneBody scene;
  BodyConfig& config = scene.body;
  if (body.has("name")) scene.body_name = body.text("name", "a name", "a text");
  if (material.has("model")) scene.model = material.text("model", "a model", "its name, such as \"springs\"");
  scene.refine = body.whole("refine", split_parts, scene.refine);
  read_cells(tables, folder, scene);
  if (!scene.mesh) {
    config.cell_size = body.number("cell_size", length) / scene.refine;
    config.origin = body.vector("origin", position, Vec3::Zero());
  }
  read_contact_surface(body, scene);
  read_thickness(body, scene, warnings);
  config.topology = body.choice("topology", "a topology", topologies, Topology::full);
  config.sharing = body.choice("sharing", "a way of sharing springs", sharings, Sharing::weighted);
  if (config.sharing != Sharing::weighted && !config.content_of.empty())
    body.reject("sharing", "is for full cells of one part; leave it out, or give \"weighted\"");
  read_material(tables, scene, warnings);
  for (const TomlTable& table : tables.weights)
    read_keys(weight_keys(), table, config.weights.emplace_back());
  read_keys(start_keys(), tables.start, scene);
  return scene;
}

}  // namespace mss
