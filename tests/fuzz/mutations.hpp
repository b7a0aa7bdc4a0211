#pragma once

#include <string>

#include "tests/fuzz/random.hpp"
#include "tests/fuzz/seeds.hpp"

namespace mss::fuzz {

/// Damages the bytes of any file: flips, insertions, deletions, copies, truncations; `other` is what pieces
/// are taken from.
void damage_bytes(std::string& text, const std::string& other, Random& random);

/// Damages the lines and numbers of a text: numbers become extremes, lines are repeated, swapped, left out.
void damage_lines(std::string& text, const std::string& other, Random& random);

/// Damages a scene so that most of it stays one: keys with other values, of other tables, of other types.
void damage_scene(std::string& text, const std::string& other, Random& random);

/// Leaves out what stands twice in a table, which is no TOML.
void drop_repeated_keys(std::string& text);

/// Damages a voxel file.
void damage_voxels(std::string& text, const std::string& other, Random& random);

/// Damages a mesh file of a kind: indices, counts, heads, keywords.
void damage_mesh(Kind kind, std::string& text, const std::string& other, Random& random);

/// "table.key=value" for --set.
std::string random_override(Random& random);

}  // namespace mss::fuzz
