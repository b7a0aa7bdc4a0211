#pragma once

#include <random>
#include <string>
#include <vector>

#include "core/spring_system.hpp"
#include "reference/algorithm1.hpp"

namespace mss::testing {

struct NamedVoxels {
  std::string name;
  VoxelGrid voxels;
};

/// Cubes, thin plates along each axis, an L, a sphere and 30 %-random voxels: every way a block can be
/// divided.
inline std::vector<NamedVoxels> test_shapes() {
  std::vector<NamedVoxels> shapes{{"cube1", VoxelGrid::box(1, 1, 1)},   {"cube3", VoxelGrid::box(3, 3, 3)},
                                  {"cube5", VoxelGrid::box(5, 5, 5)},   {"plate_z", VoxelGrid::box(9, 7, 1)},
                                  {"plate_y", VoxelGrid::box(8, 1, 5)}, {"plate_x", VoxelGrid::box(1, 6, 7)},
                                  {"beam", VoxelGrid::box(17, 2, 2)}};
  VoxelGrid ell(6, 5, 4);
  VoxelGrid sphere(9, 9, 9);
  VoxelGrid random(11, 8, 7);
  std::mt19937 rng(7);
  const auto each = [](VoxelGrid& g, auto&& inside) {
    for (int k = 0; k < g.nz(); ++k)
      for (int j = 0; j < g.ny(); ++j)
        for (int i = 0; i < g.nx(); ++i) g.set(i, j, k, inside(i, j, k));
  };
  each(ell, [](int i, int j, int) { return i < 2 || j < 2; });
  each(sphere,
       [](int i, int j, int k) { return (i - 4) * (i - 4) + (j - 4) * (j - 4) + (k - 4) * (k - 4) <= 18; });
  each(random, [&](int, int, int) { return std::uniform_real_distribution<>(0, 1)(rng) < 0.3; });
  shapes.push_back({"ell", ell});
  shapes.push_back({"sphere", sphere});
  shapes.push_back({"random30", random});
  return shapes;
}

/// A body configuration whose forces are all of the same order.
inline BodyConfig test_config(const VoxelGrid& voxels) {
  return {.voxels = voxels,
          .cell_size = 0.2,
          .origin = Vec3(0.3, -0.1, 0.5),
          .density = 900,
          .springs = {.edge = 120, .face = 80, .body = 250, .volume = 700},
          .damping = {.law = Damping::Law::ratio, .zeta = 0.1}};
}

/// Displaces every particle by up to `amplitude` cells and gives it a velocity of up to `speed`.
template <class Real>
void randomise(const Body& body, State<Real>& state, double amplitude, double speed, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<> u(-1, 1);
  const double size = amplitude * body.config().cell_size;
  for (const std::ptrdiff_t site : body.sites()) {
    state.x.set(site, state.x.at(site) + size * Vec3(u(rng), u(rng), u(rng)));
    state.v.set(site, speed * Vec3(u(rng), u(rng), u(rng)));
  }
}

/// Gives Algorithm 1 exactly the positions and velocities of the state, in its precision.
template <class Real>
void copy_state(const Body& body, const State<Real>& state, reference::Algorithm1& oracle) {
  for (std::size_t id = 0; id < body.sites().size(); ++id) {
    oracle.particles()[id].x = state.x.at(body.sites()[id]);
    oracle.particles()[id].v = state.v.at(body.sites()[id]);
  }
}

}  // namespace mss::testing
