#pragma once

#include "core/spring_system.hpp"

namespace mss::testing {

inline constexpr double gravity = 9.81;  ///< [m/s^2]

/// A cell whose springs have no stiffness: eight particles that know nothing of each other.
inline BodyConfig dust() {
  return {.cell_size = 0.1, .springs = {.edge = 0, .face = 0, .body = 0, .volume = 0}};
}

/// A cube of rubber, three cells per edge, whose corner is the origin.
inline BodyConfig block() {
  BodyConfig config{.voxels = VoxelGrid::box(3, 3, 3),
                    .cell_size = 0.1,
                    .damping = {.law = Damping::Law::ratio, .zeta = 0.5}};
  config.fill({.young = 1e6, .poisson = 0.3}, 0.5);
  return config;
}

/// The thesis's cube of Fig. 5-2, five cells per edge of 1 m, in the air.
inline BodyConfig thesis_cube() {
  return {.voxels = VoxelGrid::box(5, 5, 5),
          .cell_size = 0.2,
          .origin = Vec3(-0.5, -0.5, 0.6),
          .sharing = Sharing::uniform,
          .density = 1,
          .springs = {.edge = 100, .face = 100, .body = 300, .volume = 0.1},
          .damping = {.law = Damping::Law::ratio, .zeta = 0.4}};
}

inline Vec3 centre_of_mass(const Body& body, const State<double>& state) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : body.sites())
    sum += body.mass(site) / body.total_mass() * state.x.at(site);
  return sum;
}

}  // namespace mss::testing
