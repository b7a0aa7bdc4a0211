#include "core/measures.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace mss {

namespace {

double triple(const Vec3& a, const Vec3& b, const Vec3& c) { return a.dot(b.cross(c)); }

double side(int corner, int axis) { return ((corner >> axis) & 1) != 0 ? 1.0 : -1.0; }

/// Coefficients of the trilinear map on [-1, 1]^3:
///   x = c + x1 xi + y1 eta + z1 zeta + yz eta zeta + zx zeta xi + xy xi eta + xyz xi eta zeta.
struct TrilinearMap {
  Vec3 x1 = Vec3::Zero(), y1 = Vec3::Zero(), z1 = Vec3::Zero();
  Vec3 yz = Vec3::Zero(), zx = Vec3::Zero(), xy = Vec3::Zero();

  explicit TrilinearMap(const std::array<Vec3, 8>& corners) {
    for (int c = 0; c < 8; ++c) {
      const Vec3 p = corners[std::size_t(c)] / 8;
      const double sx = side(c, 0), sy = side(c, 1), sz = side(c, 2);
      x1 += sx * p;
      y1 += sy * p;
      z1 += sz * p;
      yz += sy * sz * p;
      zx += sz * sx * p;
      xy += sx * sy * p;
    }
  }
};

/// Sums over particles.
struct SumsOfMotion {
  Vec3 momentum = Vec3::Zero(), first_moment = Vec3::Zero();
  double kinetic = 0, max_speed = 0;
};

template <class Real>
void measure_motion(const SolidSystem<Real>& system, const State<Real>& state, Measures& m) {
  SumsOfMotion sums;
  system.ranks().add_in_order(sums, [&] {
    for (const std::ptrdiff_t site : system.particles()) {
      const double mass = system.mass(site);
      const Vec3 v = state.v.at(site);
      sums.momentum += mass * v;
      sums.first_moment += mass * state.x.at(site);
      sums.kinetic += 0.5 * mass * v.squaredNorm();
      sums.max_speed = std::max(sums.max_speed, v.norm());
    }
  });
  m.momentum = sums.momentum;
  m.kinetic = sums.kinetic;
  m.max_speed = sums.max_speed;
  const Vec3 centre = sums.first_moment / system.total_mass();
  system.ranks().add_in_order(m.spin, [&] {
    for (const std::ptrdiff_t site : system.particles())
      m.spin += system.mass(site) * (state.x.at(site) - centre).cross(state.v.at(site));
  });
  m.gravitational = system.outer_potential(state.x);
}

template <class Real>
void measure_springs(const Level& level, const State<Real>& state, Measures& m) {
  level.body.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double, double) {
    const double length = (state.x.at(level.first + b) - state.x.at(level.first + a)).norm();
    m.max_stretch = std::max(m.max_stretch, std::abs(length / level.body.rest_length(slot.kind) - 1));
  });
  m.max_stretch = level.body.ranks().largest(m.max_stretch);
}

template <class Real>
void measure_cells(const std::vector<Level>& levels, const State<Real>& state, Measures& m) {
  double thesis = 0, at_rest = 0;
  m.min_jacobian = std::numeric_limits<double>::infinity();
  for (const Level& level : levels) {
    double smallest = std::numeric_limits<double>::infinity();
    level.body.ranks().add_in_order(thesis, [&] {
      level.body.for_each_cell([&](std::ptrdiff_t site) {
        const std::array<Vec3, 8> corners = corners_of(level.body, state.x, level.first + site);
        thesis += level.body.weights_at(site).fill * thesis_volume(corners);
        for (int c = 0; c < 8; ++c) smallest = std::min(smallest, corner_volume(corners, c));
      });
    });
    smallest = -level.body.ranks().largest(-smallest);
    m.min_jacobian = std::min(m.min_jacobian, smallest / level.body.cell_volume());
    at_rest += level.body.volume();
  }
  m.volume_ratio = volume_ratio(levels, state.x);
  m.volume_ratio_thesis = thesis / at_rest;
}

}  // namespace

// The Jacobian of the map is triquadratic; over the cube odd powers vanish and squares average to 1/3:
//   V = 8 ([x1 y1 z1] + ([x1 xy zx] + [xy y1 yz] + [zx yz z1]) / 3).
// The first term is the thesis's estimate, the others, products of the cell's warping modes, are missing
// there.
double trilinear_volume(const std::array<Vec3, 8>& corners) {
  const TrilinearMap m(corners);
  return 8 * (triple(m.x1, m.y1, m.z1) +
              (triple(m.x1, m.xy, m.zx) + triple(m.xy, m.y1, m.yz) + triple(m.zx, m.yz, m.z1)) / 3);
}

double thesis_volume(const std::array<Vec3, 8>& corners) {
  const TrilinearMap m(corners);
  return 8 * triple(m.x1, m.y1, m.z1);
}

double corner_volume(const std::array<Vec3, 8>& p, int corner) {
  std::array<Vec3, 3> edge;
  for (int axis = 0; axis < 3; ++axis)
    edge[std::size_t(axis)] =
        side(corner, axis) * (p[std::size_t(corner)] - p[std::size_t(corner ^ (1 << axis))]);
  return triple(edge[0], edge[1], edge[2]);
}

template <class Real>
double volume_ratio(const std::vector<Level>& levels, const Field<Real>& x) {
  double volume = 0, at_rest = 0;
  for (const Level& level : levels) {
    level.body.ranks().add_in_order(volume, [&] {
      level.body.for_each_cell([&](std::ptrdiff_t site) {
        volume += level.body.weights_at(site).fill *
                  trilinear_volume(corners_of(level.body, x, level.first + site));
      });
    });
    at_rest += level.body.volume();
  }
  return volume / at_rest;
}

template <class Real>
Measures measure(const SolidSystem<Real>& system, const State<Real>& state) {
  system.update_ghosts(state);
  Measures m;
  m.t = state.t;
  const StoredEnergy energy = system.stored_energy(state.x);
  m.elastic = energy.elastic;
  m.volume_energy = energy.volume;
  measure_motion(system, state, m);
  for (const Level& level : system.levels()) measure_springs(level, state, m);
  measure_cells(system.levels(), state, m);
  return m;
}

template double volume_ratio(const std::vector<Level>&, const Field<float>&);
template double volume_ratio(const std::vector<Level>&, const Field<double>&);
template Measures measure(const SolidSystem<float>&, const State<float>&);
template Measures measure(const SolidSystem<double>&, const State<double>&);

}  // namespace mss
