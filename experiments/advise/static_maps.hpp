#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "experiments/harness/table.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss::advise {

/// Around the particles in each box of a scene's loads, holds and displacements. A load of particles, and a
/// goal, is another one where these are.
using BoxExtents = std::vector<Eigen::AlignedBox<double, 3>>;
BoxExtents extents_of_boxes(const Scene& scene, const std::vector<ParticleRecord>& particles);
bool same_extents(const BoxExtents& a, const BoxExtents& b);

/// A scene at rest with smaller cells where an estimate of the error chooses them (body.refinement = "auto").
struct MapTried {
  double cell_size = 0;  ///< of the largest [m]
  int levels = 0;        ///< how often they are halved at most
  std::size_t particles = 0;
  double seconds = 0;       ///< of choosing the cells and the solution
  double value = no_value;  ///< of the quantity
  BoxExtents boxes{};
  double gain = no_value;  ///< particles that cells of one size need for its error, over its own
  Status status = Status::ok;
};

/// Whether cells of the scene's body can be split.
bool can_be_split(const Scene& scene);

/// Solves a scene in maps that begin with cells of given sizes, those of the scene halved or doubled so many
/// times, with 1, 2 and 3 levels as long as the particles are fewer than `most_particles`. The quantity is
/// named as CorrectedValue names it: "displacement 0 z" or "stored energy".
std::vector<MapTried> try_maps(const Scene& scene, const std::string& quantity,
                               const std::vector<double>& cell_sizes, std::size_t most_particles,
                               Progress& progress);

}  // namespace mss::advise
