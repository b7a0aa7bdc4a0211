#pragma once

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "core/springs/spring_system.hpp"
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

/// Fills cells evenly, as much as `fill` says by VoxelGrid::index().
inline void fill_evenly(BodyConfig& config, const std::vector<float>& fill) {
  for (const float f : fill) {
    config.content_of.push_back(std::uint32_t(config.contents.size()));
    config.contents.push_back({{0, CellFill::even(f)}});
  }
}

/// A fill of these octants, each filled evenly: of a corner's trilinear weight along an axis the near half of
/// a cell has 3/8, the far half 1/8.
inline CellFill fill_of(const std::array<float, 8>& octant) {
  CellFill fill{octant, {}};
  for (int corner = 0; corner < 8; ++corner)
    for (int q = 0; q < 8; ++q) {
      float weight = 8;
      for (int axis = 0; axis < 3; ++axis) weight *= ((corner ^ q) >> axis & 1) != 0 ? 0.125F : 0.375F;
      fill.corner[std::size_t(corner)] += weight * octant[std::size_t(q)];
    }
  return fill;
}

/// Two parts beside part 0, of other density, springs and damping.
inline void add_parts(BodyConfig& config) {
  config.parts = {{.name = "A",
                   .density = 2500,
                   .springs = {.edge = 300, .face = 50, .body = 400, .volume = 0},
                   .damping = {.law = Damping::Law::viscosity, .viscosity = 20}},
                  {.name = "B",
                   .density = 400,
                   .springs = {.edge = 60, .face = 90, .body = 20, .volume = 2000},
                   .damping = {.law = Damping::Law::ratio, .zeta = 0.4}}};
}

/// Random contents of a dozen kinds: octants that are empty, full or in between, of one part or, where there
/// are more, of two.
inline void fill_randomly(BodyConfig& config, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> share(0, 1);
  const auto octants = [&](float most) {
    std::array<float, 8> all{};
    for (float& octant : all) octant = most * std::clamp(1.6F * share(rng) - 0.3F, 0.0F, 1.0F);
    all[rng() % 8] = most;  // not empty
    return all;
  };
  const int parts = 1 + int(config.parts.size());
  for (int kind = 0; kind < 12; ++kind) {
    const int part = kind % parts;
    if (kind < 2 * parts)
      config.contents.push_back({{part, kind < parts ? CellFill::even(1) : fill_of(octants(1))}});
    else if (parts == 1)
      config.contents.push_back({{0, fill_of(octants(1))}});
    else
      config.contents.push_back(
          {{part, fill_of(octants(0.6F))}, {(part + 1) % parts, fill_of(octants(0.4F))}});
  }
  const auto [nx, ny, nz] = config.voxels.size();
  for (int cell = 0; cell < nx * ny * nz; ++cell) config.content_of.push_back(std::uint32_t(rng() % 12));
}

/// Cells of random fills of three parts.
inline BodyConfig mixed_config(const VoxelGrid& voxels, unsigned seed) {
  BodyConfig config = test_config(voxels);
  add_parts(config);
  fill_randomly(config, seed);
  return config;
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

/// The same of a solid, in sizes of its smallest cells; what follows other particles goes where it belongs.
template <class Real>
void randomise(const SolidSystem<Real>& system, State<Real>& state, double amplitude, double speed,
               unsigned seed) {
  for (const Level& level : system.levels()) {
    State<Real> part{0, Field<Real>(level.body.lattice().size), Field<Real>(level.body.lattice().size)};
    randomise(level.body, part, amplitude * system.cell_size() / level.body.config().cell_size, speed,
              seed++);
    for (const std::ptrdiff_t site : level.body.sites()) {
      state.x.set(level.first + site, state.x.at(level.first + site) + part.x.at(site));
      state.v.set(level.first + site, part.v.at(site));
    }
  }
  system.constrain(state.t, state.x, state.v);
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
