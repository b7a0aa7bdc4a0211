#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace mss {

/// Where the scenes that come with the program are: installed, or in its source tree. Empty if they are
/// nowhere.
std::filesystem::path scenes_directory();

/// Their names, sorted, and the first comment line of each. Prints a message to stderr if they are nowhere.
std::vector<std::pair<std::string, std::string>> listed_scenes();

/// The file of a scene given as a path, or as the name of one that comes with the program. Throws InputError
/// for a name of none.
std::filesystem::path scene_file(const std::string& given);

}  // namespace mss
