#include "core/scene/scene_writer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <functional>
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

Json body_to_json(const SceneBody& scene) {
  const BodyConfig& body = scene.body;
  Json json;
  if (!scene.body_name.empty()) json["name"] = scene.body_name;
  if (scene.mesh) {
    json["mesh"] = scene.mesh->file;
    json.update(to_json(scene.mesh->placement));
    json["fill"] = to_string(scene.mesh->config.mode);
    json["contact_on"] = scene.contact_surface ? "surface" : "particles";
  } else if (scene.voxel_file.empty())
    for (const int count : body.voxels.size()) json["cells"].push_back(count / scene.refine);
  else
    json["voxels"] = scene.voxel_file;
  json["refine"] = scene.refine;
  json["cell_count"] = body.voxels.count();
  json["cell_size"] = size_before(body.cell_size, scene.refine);
  if (!body.is_solid()) json["thickness"] = body.across();
  if (!scene.mesh) json["origin"] = to_json(body.origin);
  json["topology"] = to_string(body.topology);
  json["sharing"] = to_string(body.sharing);
  return json;
}

Json material_to_json(const SceneBody& scene) {
  const BodyConfig& body = scene.body;
  Json json{{"model", scene.model}, {"density", body.density}};
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

/// Of a scene's only body.
void add_changes_of_body(const Scene& scene, Json& json) {
  if (scene.auto_refinement) {
    json["body"]["refinement"] = "auto";
    json["body"]["refinement_levels"] = scene.auto_refinement->levels;
    json["body"]["refinement_goal"] = to_string(scene.auto_refinement->goal);
  }
  if (scene.match) {
    json["body"]["match"] = to_string(scene.match->of);
    if (scene.match->parts > 0) json["body"]["match_to"] = scene.match->parts;
  }
  if (scene.modes > 0) json["material"]["modes"] = scene.modes;
}

Json parts_to_json(const SceneBody& scene) {
  Json parts = Json::array();
  for (const Part& part : scene.body.parts) {
    parts.push_back(to_json(part));
    if (scene.mesh) parts.back()["mesh"] = scene.mesh->part_files[parts.size() - 1];
  }
  return parts;
}

template <class Target>
Json array_of(const SceneKeys<Target>& keys, const std::vector<Target>& targets) {
  Json array = Json::array();
  for (const Target& target : targets) array.push_back(written(keys, target));
  return array;
}

/// One of several bodies, with all that the file says of it.
Json one_to_json(const SceneBody& one) {
  Json json = body_to_json(one);
  json["material"] = material_to_json(one);
  json["damping"] = to_json(one.body.damping);
  json["start"] = written(start_keys(), one);
  if (!one.body.parts.empty()) json["part"] = parts_to_json(one);
  if (!one.body.weights.empty()) json["weight"] = array_of(weight_keys(), one.body.weights);
  return json;
}

/// Leaves out what follows from something else; files are named from `folder` on.
void make_file_of(const SceneBody& one, const std::function<std::string(const std::string&)>& from_folder,
                  Json& body, Json& material, Json& damping, Json& parts) {
  if (!one.voxel_file.empty()) body["voxels"] = from_folder(one.voxel_file);
  if (one.mesh) body["mesh"] = from_folder(one.mesh->file);
  for (std::size_t i = 0; one.mesh && i < one.mesh->part_files.size(); ++i)
    parts[i]["mesh"] = from_folder(one.mesh->part_files[i]);
  if (one.body.elastic)
    for (const char* key : {"springs", "volume"}) material.erase(key);
  damping = damping_of_file(one.body.damping);
}

/// What a scene file has of it: nothing that follows from something else.
Json file_of(const Scene& scene, const std::filesystem::path& folder) {
  Json json = to_json(scene);
  json.erase("name");
  const auto from_folder = [&](const std::string& file) {
    return std::filesystem::absolute(scene.file.parent_path() / file)
        .lexically_proximate(std::filesystem::absolute(folder))
        .generic_string();
  };
  for (Json& obstacle : json["obstacle"])
    if (obstacle.contains("mesh")) obstacle["mesh"] = from_folder(obstacle["mesh"]);
  if (scene.others.empty()) {
    json["body"].erase("cell_count");
    make_file_of(scene, from_folder, json["body"], json["material"], json["damping"], json["part"]);
    return json;
  }
  const std::vector<const SceneBody*> bodies = bodies_of(scene);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    Json& body = json["body"][b];
    body.erase("cell_count");
    Json none = Json::array();
    make_file_of(*bodies[b], from_folder, body, body["material"], body["damping"],
                 body.contains("part") ? body["part"] : none);
  }
  return json;
}

/// JSON's texts, numbers, truth values and arrays are TOML's too, and a table on one line nearly.
std::string value_to_toml(const Json& value) {
  std::vector<std::string> entries;
  if (value.is_array() && !value.empty() && value.front().is_object()) {
    for (const Json& inner : value) entries.push_back(value_to_toml(inner));
    return fmt::format("[{}]", fmt::join(entries, ", "));
  }
  if (!value.is_object()) return value.dump(-1, ' ', false, Json::error_handler_t::replace);
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
  const Environment& environment = scene.environment;
  Json holds = Json::array(), obstacles = Json::array();
  for (const Hold& hold : environment.holds) holds.push_back(to_json(hold));
  for (const Obstacle& obstacle : environment.obstacles) obstacles.push_back(to_json(obstacle));
  Json json{{"name", scene.name}};
  if (scene.others.empty()) {
    json["body"] = body_to_json(scene);
    json["material"] = material_to_json(scene);
    add_changes_of_body(scene, json);
    json["damping"] = to_json(scene.body.damping);
    json["part"] = parts_to_json(scene);
    json["weight"] = array_of(weight_keys(), scene.body.weights);
    json["refine"] = array_of(refine_keys(), scene.refined_boxes);
  } else {
    for (const SceneBody* one : bodies_of(scene)) json["body"].push_back(one_to_json(*one));
  }
  json["environment"] = written(environment_keys(), environment);
  if (scene.states_contact || environment.contact.acts())
    json["contact"] = written(contact_keys(), environment.contact);
  json["hold"] = holds;
  json["load"] = array_of(load_keys(), environment.loads);
  json["strike"] = array_of(strike_keys(), environment.strikes);
  json["plane"] = array_of(plane_keys(), environment.planes);
  json["obstacle"] = obstacles;
  if (scene.others.empty()) json["start"] = written(start_keys(), static_cast<const SceneBody&>(scene));
  json["solve"] = written(solve_keys(), scene.solve);
  json["expect"] = to_json(scene.expectations);
  return json;
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
