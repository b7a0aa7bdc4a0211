#include "core/measures/measures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/record.hpp"
#include "core/forces/cell_geometry.hpp"
#include "core/forces/spring_law.hpp"

namespace mss {

namespace {

/// Sums over particles: momentum, first moment of mass, kinetic energy; and the largest speed.
class SumsOfMotion {
 public:
  auto momentum() { return numbers_.segment<3>(0); }
  auto first_moment() { return numbers_.segment<3>(3); }
  double& kinetic() { return numbers_[6]; }
  double& max_speed() { return numbers_[7]; }
  double* data() { return numbers_.data(); }
  static std::size_t size() { return 8; }

 private:
  Eigen::Matrix<double, 8, 1> numbers_ = Eigen::Matrix<double, 8, 1>::Zero();
};

template <class Real>
void measure_motion(const SolidSystem<Real>& system, const State<Real>& state, Measures& m) {
  SumsOfMotion sums;
  system.ranks().add_in_order(sums, [&] {
    for (const std::ptrdiff_t site : system.particles()) {
      const double mass = system.mass(site);
      const Vec3 v = state.v.at(site);
      sums.momentum() += mass * v;
      sums.first_moment() += mass * state.x.at(site);
      sums.kinetic() += 0.5 * mass * v.squaredNorm();
      sums.max_speed() = std::max(sums.max_speed(), v.norm());
    }
  });
  m.momentum = sums.momentum();
  m.kinetic = sums.kinetic();
  m.max_speed = sums.max_speed();
  const Vec3 centre = sums.first_moment() / system.total_mass();
  system.ranks().add_in_order(m.angular_momentum, [&] {
    for (const std::ptrdiff_t site : system.particles())
      m.angular_momentum += system.mass(site) * (state.x.at(site) - centre).cross(state.v.at(site));
  });
  m.external_potential = system.outer_potential(state.t, state.x);
}

template <class Real>
void measure_springs(const Level& level, const State<Real>& state, Measures& m) {
  level.body.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double, double) {
    const double length = (state.x.at(level.first + b) - state.x.at(level.first + a)).norm();
    m.max_stretch =
        std::max(m.max_stretch, std::abs(spring_strain(length, level.body.rest_length(slot.kind))));
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

void Measures::remember(Record& record) {
  record.keep(t, kinetic, elastic, volume_energy, external_potential, volume_ratio, volume_ratio_thesis,
              momentum, angular_momentum, max_speed, max_stretch, min_jacobian);
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
