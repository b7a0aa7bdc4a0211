#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/state.hpp"
#include "core/scene/scene.hpp"
#include "core/springs/body_system.hpp"
#include "experiments/harness/json.hpp"
#include "experiments/harness/progress.hpp"

// What `mss peer export` gives other programs: a scene as tables, and the motion that is right.

namespace mss::peer {

/// How scene.json names its format.
inline constexpr const char* exchange_format = "mss-peer-1";

/// How a reference was made.
struct ReferenceFacts {
  std::string integrator{};
  double dt = 0;  ///< [s]
  /// Its distance from the motion in steps twice as long, over the largest displacement: root mean square
  /// over particles and sample times.
  double uncertainty = 0;
};

/// A scene for other programs: its body and system in the core, when to sample it, and its true motion.
struct Exchange {
  Scene scene;
  std::unique_ptr<const Body> body{};
  std::unique_ptr<BodySystem<double>> system{};  ///< of the scene's model
  State<double> start{};
  double spacing = 0;                      ///< of samples [s]
  std::vector<double> times{};             ///< of samples, 0 the first [s]
  std::vector<State<double>> reference{};  ///< by sample, on the lattice; empty: not computed
  ReferenceFacts facts{};
  Json provenance{};  ///< of the reference
};

/// The default time between samples [s].
inline constexpr double default_spacing = 1.0 / 60;

/// A scene without its reference. Samples are `spacing` [s] apart, from t = 0 to the scene's end. Throws
/// InputError where the tables cannot say what the scene has: holds that move or leave an axis free, loads in
/// time, strikes, cells of several sizes, springs that relax, surfaces that planes touch, equilibria.
Exchange make_exchange(const Scene& scene, double spacing = default_spacing);

/// Computes the reference: by rk4, or where planes are by a method of first order at short steps, halved
/// until halving moves the motion by less than 1e-4 of its largest displacement, or a few times. Throws
/// InputError where the motion is not finite. Nothing is there if the progress was stopped.
void add_reference(Exchange& exchange, Progress& progress);

/// Writes the folder (experiments/peer/README.md): scene.json, scene.toml, particles.csv, springs.csv,
/// hexahedra.csv, tetrahedra.csv, reference.csv. Throws InputError if that fails.
void write_export(const Exchange& exchange, const std::filesystem::path& directory);

/// Reads what write_export() wrote. Throws InputError naming the file.
Exchange read_export(const std::filesystem::path& directory);

}  // namespace mss::peer
