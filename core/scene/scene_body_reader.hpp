#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

#include "core/scene/scene_body.hpp"
#include "core/scene/toml_reader.hpp"

namespace mss {

/// The tables of a scene file that are about one body.
struct BodyTables {
  TomlTable body, material, damping, start;
  std::vector<TomlTable> parts, weights;
};

/// Those of [body], or of each [[body]]: there what a body says itself stands for what the scene says of all.
std::vector<BodyTables> body_tables(const TomlTable& root);

/// Rejects keys of cells of three dimensions, for a body of squares or links.
void refuse_of_cells(const TomlTable& table, std::initializer_list<const char*> keys,
                     const BodyConfig& config);

/// Reads a body; its files are relative to `folder`. Adds sentences for the user to `warnings`. Throws
/// InputError with file, line and key.
SceneBody read_scene_body(const BodyTables& tables, const std::filesystem::path& folder,
                          std::vector<std::string>& warnings);

}  // namespace mss
