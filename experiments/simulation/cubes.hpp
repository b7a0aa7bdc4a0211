#pragma once

#include "core/body/body.hpp"

// Bodies that several studies and tests share.

namespace mss {

/// The thesis's springs [N/m] and k_vol [Pa], chapter 5.
inline constexpr SpringConstants thesis_springs{.edge = 100, .face = 100, .body = 300, .volume = 0.1};

/// The thesis's cube of Fig. 5-2, five cells per edge of 1 m, in the air.
inline BodyConfig thesis_cube() {
  return {.voxels = VoxelGrid::box(5, 5, 5),
          .cell_size = 0.2,
          .origin = Vec3(-0.5, -0.5, 0.6),
          .sharing = Sharing::uniform,
          .density = 1,
          .springs = thesis_springs,
          .damping = {.law = Damping::Law::ratio, .zeta = 0.4}};
}

/// A cell whose springs have no stiffness: eight particles that do not interact.
inline BodyConfig free_particles() {
  return {.cell_size = 0.1, .springs = {.edge = 0, .face = 0, .body = 0, .volume = 0}};
}

/// A cube of rubber of 0.3 m, three cells per edge, whose corner is the origin.
inline BodyConfig rubber_block() {
  BodyConfig config{.voxels = VoxelGrid::box(3, 3, 3),
                    .cell_size = 0.1,
                    .damping = {.law = Damping::Law::ratio, .zeta = 0.5}};
  config.fill({.young = 1e6, .poisson = 0.3}, 0.5);
  return config;
}

/// A cube of 1 m at n cells per edge, of calibrated springs with t = 0.5; `ratio` of damping to critical, of
/// every spring.
inline BodyConfig unit_cube(const ElasticConstants& material, double density, int n, double ratio) {
  BodyConfig config{.voxels = VoxelGrid::box(n, n, n), .cell_size = 1.0 / n, .density = density};
  if (ratio > 0) config.damping = {.law = Damping::Law::ratio, .zeta = ratio};
  config.fill(material, 0.5);
  return config;
}

}  // namespace mss
