#pragma once

#include <cstddef>
#include <limits>
#include <string>

#include "core/scene/scene.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// What a run of a scene would compute, and about how long it would take.
struct RunPreview {
  Vec3 extent = Vec3::Zero();  ///< of the body at rest [m]
  double mass = 0;             ///< [kg]
  std::size_t cells = 0, particles = 0;
  /// NaN: of the method's own choice, or none [s].
  double dt = std::numeric_limits<double>::quiet_NaN();
  long steps = 0;                ///< of fixed length
  Status status = Status::ok;    ///< of the steps that were taken to time them
  double simulated_seconds = 0;  ///< in these
  double wall_seconds = 0;       ///< they took
  std::size_t memory_bytes = 0;  ///< that the program had at most so far

  /// Of the whole run, as these steps have it [s].
  double expected_seconds(double duration) const { return duration * wall_seconds / simulated_seconds; }
};

/// Sets a scene up and takes a few steps, for about half a second. Throws InputError as a run would.
RunPreview preview_run(const Scene& scene);

/// Extent, mass and cells, as in "0.4 x 0.1 x 0.1 m, 4 kg, 32 cells, 81 particles"; of a sheet or a rope "a
/// rope of 0.8 m, 0.1 m thick, ...".
std::string body_in_words(const Scene& scene, const Vec3& extent, double mass, std::size_t cells,
                          std::size_t particles);

}  // namespace mss
