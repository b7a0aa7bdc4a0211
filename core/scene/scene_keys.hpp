#pragma once

// One table of the keys of a scene file: from it the reader takes values, the writer writes them, unknown
// keys get suggestions and core/scene/README.md gets its reference. A new key is a line in scene_keys.cpp.

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/scene/toml_reader.hpp"

namespace mss {

/// A key of a table.
struct KeyText {
  std::string name, allowed, meaning;  ///< `allowed`: what may be given
};
template <class Target>
struct SceneKey : KeyText {
  /// Both are empty where a value is read and written with others (scene.cpp, scene_writer.cpp).
  std::function<void(const TomlTable&, Target&)> read{};
  std::function<void(const Target&, nlohmann::ordered_json&)> write{};
};
template <class Target>
using SceneKeys = std::vector<SceneKey<Target>>;

/// Reads what a table has of its keys; what it lacks stays. Throws as TomlTable does.
template <class Target>
void read_keys(const SceneKeys<Target>& keys, const TomlTable& table, Target& target) {
  for (const SceneKey<Target>& key : keys)
    if (key.read) key.read(table, target);
}
template <class Target>
nlohmann::ordered_json written(const SceneKeys<Target>& keys, const Target& target) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const SceneKey<Target>& key : keys)
    if (key.write) key.write(target, json);
  return json;
}

const SceneKeys<Hold>& hold_keys();
const SceneKeys<Turn>& turn_keys();
const SceneKeys<Load>& load_keys();
const SceneKeys<Strike>& strike_keys();
const SceneKeys<Plane>& plane_keys();
const SceneKeys<Obstacle>& obstacle_keys();
const SceneKeys<Environment>& environment_keys();
const SceneKeys<BodyContact>& contact_keys();
const SceneKeys<Weight>& weight_keys();
const SceneKeys<RefinedBox>& refine_keys();
const SceneKeys<SceneBody>& start_keys();
const SceneKeys<SolveConfig>& solve_keys();

nlohmann::ordered_json to_json(const Vec3& v);
nlohmann::ordered_json to_json(const Box& box);

/// All keys of a scene file. Any other key is an error that suggests the nearest of these.
const KnownKeys& scene_keys();

/// Keys that had other names before.
const RenamedKeys& renamed_scene_keys();

}  // namespace mss
