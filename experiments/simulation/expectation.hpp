#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "experiments/harness/baseline.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss {

/// The end of a simulated scene, by this program or another.
struct SceneEnd {
  std::string status;
  std::string scene{};                            ///< its name; empty: not known
  double dt = no_value;                           ///< the step [s]
  std::map<std::string, double> first{}, last{};  ///< rows of series.csv, by column
  std::vector<ParticleRecord> particles{};
};
SceneEnd scene_end_of(const SimulationResult& result);

/// Reads summary.json, series.csv and particles.csv from a directory: what `mss run` left there, or another
/// program that writes the same files. Throws InputError naming file and line.
SceneEnd read_scene_end(const std::filesystem::path& directory);

/// Why results may be of another scene, or of this one with other settings, a sentence each.
std::vector<std::string> doubts_about(const Scene& scene, const SceneEnd& end);

/// Compares a scene's end with the scene's [expect]. A status other than ok deviates too.
std::vector<Deviation> compare_with_expectations(const Scene& scene, const SceneEnd& end);

}  // namespace mss
