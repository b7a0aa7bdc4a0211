#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace mss::fuzz {

/// What is damaged.
enum class Kind { scene, voxels, obj, stl, ply };
inline constexpr std::array<const char*, 5> kind_names{"scene", "voxels", "OBJ", "STL", "PLY"};
inline constexpr std::array<const char*, 5> mutant_files{"scene.toml", "mutant.txt", "mutant.obj",
                                                         "mutant.stl", "mutant.ply"};

/// Sound files that inputs are made from.
struct Seeds {
  std::array<std::vector<std::string>, 5> texts;  ///< by Kind
  std::map<std::string, std::string> companions;  ///< by name: what scenes may refer to
};

/// The scenes and voxel files of a folder, in fewer cells where they have many, and small meshes.
Seeds make_seeds(const std::filesystem::path& scenes);

}  // namespace mss::fuzz
