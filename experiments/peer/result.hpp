#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/peer/exchange.hpp"

namespace mss::peer {

/// What a program made of an exported scene.
struct Result {
  std::string name{};  ///< of its folder, or of the method
  std::string engine{}, version{};
  double step = 0;                  ///< [s]
  std::optional<int> iterations{};  ///< of a step
  std::string precision{};          ///< "single" or "double"
  int threads = 1;
  double wall_seconds = 0, cpu_seconds = 0;  ///< of stepping alone
  Json settings{};                           ///< whatever else it was told; null: nothing
  bool has_velocities = false;
  /// By sample time on the body's lattice; those before the first that is missing or wrong.
  std::vector<State<double>> samples{};
  std::string problem{};  ///< what keeps the samples from being complete, in words; empty: nothing
  /// The problem is the motion's: numbers are not finite, or cost.json says that it blew up.
  bool diverged = false;
};

/// Reads cost.json and, if its status is "ok", samples.csv. What is wrong with samples (late, missing,
/// repeated or foreign particles, numbers that are not finite), and any other status, becomes `problem`.
/// Throws InputError naming file and line where a file is missing or is not what experiments/peer/README.md
/// says.
Result read_result(const std::filesystem::path& directory, const Exchange& exchange);

/// Runs the scene by mss itself, as its [solve] says, and keeps the samples: a result like another's. Where
/// dt is "safe" it is shortened to divide the time between samples; other steps must.
Result run_own(const Scene& scene, const Exchange& exchange, const Progress& progress);

}  // namespace mss::peer
