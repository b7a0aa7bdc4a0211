#include "core/scene/scene_writer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/scene/scene_keys.hpp"

namespace mss {

namespace {

using Json = nlohmann::ordered_json;
using mss::to_json;

/// The size of cells before they were split: the number that gives the size they have when divided again.
double size_before(double cell_size, int refine) {
  const double product = cell_size * refine;
  for (const double size : {product, std::nextafter(product, 0.0), std::nextafter(product, 2 * product)})
    if (size / refine == cell_size) return size;
  return product;
}

Json to_json(const Placement& placement) {
  return {{"mesh_scale", placement.scale},
          {"mesh_rotation", {{"axis", to_json(placement.axis)}, {"degrees", placement.degrees}}},
          {"mesh_translation", to_json(placement.translation)}};
}

Json body_to_json(const Scene& scene) {
  const BodyConfig& body = scene.body;
  Json json;
  if (scene.mesh) {
    json["mesh"] = scene.mesh->file;
    json.update(to_json(scene.mesh->placement));
    json["fill"] = to_string(scene.mesh->config.mode);
    json["contact_on"] = scene.environment.contact_surface ? "surface" : "particles";
  } else if (scene.voxel_file.empty())
    for (const int count : body.voxels.size()) json["cells"].push_back(count / scene.refine);
  else
    json["voxels"] = scene.voxel_file;
  json["refine"] = scene.refine;
  if (scene.auto_refinement) {
    json["refinement"] = "auto";
    json["refinement_levels"] = scene.auto_refinement->levels;
    json["refinement_goal"] = to_string(scene.auto_refinement->goal);
  }
  if (scene.match) {
    json["match"] = to_string(scene.match->of);
    if (scene.match->parts > 0) json["match_to"] = scene.match->parts;
  }
  json["cell_count"] = body.voxels.count();
  json["cell_size"] = size_before(body.cell_size, scene.refine);
  if (!body.is_solid()) json["thickness"] = body.across();
  if (!scene.mesh) json["origin"] = to_json(body.origin);
  json["topology"] = to_string(body.topology);
  json["sharing"] = to_string(body.sharing);
  return json;
}

Json material_to_json(const Scene& scene) {
  const BodyConfig& body = scene.body;
  Json json{{"model", scene.model}, {"density", body.density}};
  if (scene.modes > 0) json["modes"] = scene.modes;
  if (body.elastic) {
    json["young"] = body.elastic->young;
    if (body.is_solid()) {
      json["poisson"] = body.elastic->poisson;
      json["face_share"] = scene.face_share;
    }
    if (!scene.volume_force) json["volume_force"] = false;
  }
  json["springs"] = {{"edge", body.springs.edge}, {"face", body.springs.face}, {"body", body.springs.body}};
  json["volume"] = body.springs.volume;
  json["fold_guard"] = body.fold_guard;
  if (body.relaxation.acts())
    json["relaxation"] = {{"ratio", body.relaxation.ratio}, {"time", body.relaxation.time}};
  return json;
}

Json to_json(const Damping& damping) {
  return {{"ratio", damping.zeta},
          {"viscosity", damping.viscosity},
          {"thesis", damping.law == Damping::Law::thesis}};
}

/// What a scene file has of it: what the law reads.
Json damping_of_file(const Damping& damping) {
  Json json = to_json(damping);
  if (damping.law != Damping::Law::viscosity) json.erase("viscosity");
  if (damping.law == Damping::Law::thesis || damping.law == Damping::Law::viscosity) json.erase("ratio");
  if (damping.law != Damping::Law::thesis) json.erase("thesis");
  return json;
}

/// Springs that are not calibrated are [material]'s.
Json to_json(const Part& part) {
  Json json{{"name", part.name}, {"density", part.density}};
  if (part.elastic) {
    json["young"] = part.elastic->young;
    json["poisson"] = part.elastic->poisson;
  }
  json["damping"] = damping_of_file(part.damping);
  return json;
}

Json to_json(const Hold& hold) {
  Json json = written(hold_keys(), hold);
  if (hold.turn) json["turn"] = written(turn_keys(), *hold.turn);
  return json;
}

Json to_json(const Obstacle& obstacle) {
  Json json = written(obstacle_keys(), obstacle);
  if (obstacle.turn) json["turn"] = written(turn_keys(), *obstacle.turn);
  return json;
}

Json to_json(const std::vector<Expectation>& expectations) {
  Json json = Json::object();
  for (const Expectation& e : expectations) {
    json[e.quantity] = {{"value", e.value}, {"within", e.within}};
    if (e.quantity == mean_displacement)
      json[e.quantity][e.on_surface ? "surface_box" : "box"] = to_json(e.box);
    else
      json[e.quantity]["value"] = e.value.front();
  }
  return json;
}

/// What a scene file has of it: nothing that follows from something else.
Json file_of(const Scene& scene, const std::filesystem::path& folder) {
  Json json = to_json(scene);
  json.erase("name");
  json["body"].erase("cell_count");
  const auto from_folder = [&](const std::string& file) {
    return std::filesystem::absolute(scene.file.parent_path() / file)
        .lexically_proximate(std::filesystem::absolute(folder))
        .generic_string();
  };
  if (!scene.voxel_file.empty()) json["body"]["voxels"] = from_folder(scene.voxel_file);
  if (scene.mesh) json["body"]["mesh"] = from_folder(scene.mesh->file);
  for (std::size_t i = 0; scene.mesh && i < scene.mesh->part_files.size(); ++i)
    json["part"][i]["mesh"] = from_folder(scene.mesh->part_files[i]);
  for (Json& obstacle : json["obstacle"])
    if (obstacle.contains("mesh")) obstacle["mesh"] = from_folder(obstacle["mesh"]);
  if (scene.body.elastic)
    for (const char* key : {"springs", "volume"}) json["material"].erase(key);
  json["damping"] = damping_of_file(scene.body.damping);
  return json;
}

/// JSON's texts, numbers, truth values and arrays are TOML's too, and a table on one line nearly.
std::string value_to_toml(const Json& value) {
  if (!value.is_object()) return value.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::vector<std::string> entries;
  for (const auto& [key, inner] : value.items())
    entries.push_back(fmt::format("{} = {}", key, value_to_toml(inner)));
  return fmt::format("{{ {} }}", fmt::join(entries, ", "));
}

void add_table(std::string& text, const std::string& heading, const Json& table) {
  if (table.empty()) return;
  text += heading + "\n";
  for (const auto& [key, value] : table.items()) text += fmt::format("{} = {}\n", key, value_to_toml(value));
}

}  // namespace

Json to_json(const Scene& scene) {
  Json parts = Json::array(), weights = Json::array(), holds = Json::array(), loads = Json::array(),
       strikes = Json::array(), planes = Json::array(), obstacles = Json::array(), boxes = Json::array();
  for (const Part& part : scene.body.parts) {
    parts.push_back(to_json(part));
    if (scene.mesh) parts.back()["mesh"] = scene.mesh->part_files[parts.size() - 1];
  }
  for (const Weight& weight : scene.body.weights) weights.push_back(written(weight_keys(), weight));
  for (const RefinedBox& refined : scene.refined_boxes) boxes.push_back(written(refine_keys(), refined));
  for (const Hold& hold : scene.environment.holds) holds.push_back(to_json(hold));
  for (const Load& load : scene.environment.loads) loads.push_back(written(load_keys(), load));
  for (const Strike& strike : scene.environment.strikes) strikes.push_back(written(strike_keys(), strike));
  for (const Plane& plane : scene.environment.planes) planes.push_back(written(plane_keys(), plane));
  for (const Obstacle& obstacle : scene.environment.obstacles) obstacles.push_back(to_json(obstacle));
  return {{"name", scene.name},
          {"body", body_to_json(scene)},
          {"material", material_to_json(scene)},
          {"damping", to_json(scene.body.damping)},
          {"part", parts},
          {"weight", weights},
          {"refine", boxes},
          {"environment", written(environment_keys(), scene.environment)},
          {"hold", holds},
          {"load", loads},
          {"strike", strikes},
          {"plane", planes},
          {"obstacle", obstacles},
          {"start", written(start_keys(), scene)},
          {"solve", written(solve_keys(), scene.solve)},
          {"expect", to_json(scene.expectations)}};
}

std::string to_toml(const Scene& scene, const std::filesystem::path& folder) {
  const Json file = file_of(scene, folder);
  std::string text;
  for (const auto& [name, entry] : file.items()) {
    if (entry.is_array())
      for (const Json& table : entry) add_table(text, fmt::format("[[{}]]", name), table);
    else
      add_table(text, fmt::format("[{}]", name), entry);
  }
  return text;
}

}  // namespace mss
