#pragma once

#include <filesystem>
#include <string>

namespace mss {

/// The folder whose files have the paths they have in the source tree, as in "experiments/scenes": that of
/// the installation which this program or Python module belongs to, wherever it was moved, or the source
/// tree.
std::filesystem::path shipped_files();

/// A program that only this one runs, of the installation or the build.
std::filesystem::path helper_program(const std::string& name);

}  // namespace mss
