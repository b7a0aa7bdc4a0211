#include "experiments/simulation/scene_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "core/base/suggest.hpp"
#include "experiments/io/installation.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

/// The first comment line of a scene file, without its mark; empty if it starts with something else.
std::string description(const fs::path& scene) {
  std::ifstream stream(scene);
  std::string line;
  std::getline(stream, line);
  if (line.empty() || line[0] != '#') return {};
  line.erase(0, line.find_first_not_of("# "));
  return line;
}

}  // namespace

fs::path scenes_directory() {
  const fs::path directory = shipped_files() / "experiments" / "scenes";
  std::error_code error;
  return fs::is_directory(directory, error) ? directory : fs::path();
}

std::vector<std::pair<std::string, std::string>> listed_scenes() {
  const fs::path directory = scenes_directory();
  if (directory.empty()) {
    fmt::print(stderr,
               "mss: the scenes that come with the program are neither installed nor in its source tree\n");
    return {};
  }
  std::vector<std::pair<std::string, std::string>> scenes;
  for (const auto& entry : fs::directory_iterator(directory))
    if (entry.path().extension() == ".toml")
      scenes.emplace_back(entry.path().stem().string(), description(entry.path()));
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

fs::path scene_file(const std::string& given) {
  if (fs::is_regular_file(given) || fs::path(given).has_parent_path() || fs::path(given).has_extension())
    return given;
  fs::path listed = scenes_directory() / (given + ".toml");
  if (fs::exists(listed))
    return listed;  // even if something else has that name here, such as a run's directory
  if (fs::exists(given)) return given;
  std::vector<std::string> names;
  for (const auto& [name, description] : listed_scenes()) names.push_back(name);
  throw_unknown(given, names, "scene", "scenes");
}

}  // namespace mss
