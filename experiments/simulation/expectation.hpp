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
  std::map<std::string, double> first{}, last{};  ///< rows of series.csv, by column
  std::vector<ParticleRecord> particles{};
};
SceneEnd scene_end_of(const SimulationResult& result);

/// The same of a state at its end, but for forces of holds and planes: all is measured by the system.
SceneEnd scene_end_of(const Scene& scene, const SolidSystem<double>& system, const State<double>& end);

/// Reads summary.json, series.csv and particles.csv from a directory (experiments/peer/README.md): what
/// `mss run` left there, or another program that writes the same files. All that positions and velocities
/// determine is measured from particles.csv; of series.csv the last time counts, and columns of forces and of
/// relaxation that [expect] asks for. Throws InputError naming file and line where something is missing,
/// particles are not the scene's, or results that are "ok" end at another time.
SceneEnd read_scene_end(const Scene& scene, const std::filesystem::path& directory);

/// Why results may be of another scene, a sentence each.
std::vector<std::string> doubts_about(const Scene& scene, const SceneEnd& end);

/// Whether positions and velocities at the end determine a quantity of [expect]: forces of holds and planes,
/// which are means over some time, and energies of bodies that relax they do not.
bool follows_from_state(const Scene& scene, const std::string& quantity);

/// Compares a scene's end with the scene's [expect]. A status other than ok deviates too.
std::vector<Deviation> compare_with_expectations(const Scene& scene, const SceneEnd& end);

}  // namespace mss
