#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/fuzz/seeds.hpp"

namespace mss::fuzz {

/// What a user might give: a scene, a file that it names, and settings of the command line.
struct Input {
  Kind kind = Kind::scene;
  std::map<std::string, std::string> files;  ///< content by name; scene.toml is one of them
  std::vector<std::string> overrides;
};

/// The input of a number: the same for the same seed, whatever else was made.
Input make_input(const Seeds& seeds, std::uint64_t seed, std::uint64_t index);

/// A scene around a sound or damaged voxel file or mesh.
std::string scene_around(Kind kind, const std::string& file, std::size_t variant);
inline constexpr std::size_t scene_variants = 4;

}  // namespace mss::fuzz
