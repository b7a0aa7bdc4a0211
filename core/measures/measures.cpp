#include "core/measures/measures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/record.hpp"
#include "core/forces/cell_geometry.hpp"
#include "core/forces/spring_law.hpp"
#include "core/measures/distortion.hpp"

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

/// Volume over that at rest by the thesis's estimate.
template <class Real>
double thesis_ratio(const std::vector<Level>& levels, const Field<Real>& x) {
  if (!levels.front().body.config().is_solid()) return 1;
  double thesis = 0, at_rest = 0;
  for (const Level& level : levels) {
    level.body.ranks().add_in_order(thesis, [&] {
      level.body.for_each_cell([&](std::ptrdiff_t site) {
        thesis +=
            level.body.weights_at(site).fill * thesis_volume(corners_of(level.body, x, level.first + site));
      });
    });
    at_rest += level.body.volume();
  }
  return thesis / at_rest;
}

}  // namespace

template <class Real>
double volume_ratio(const std::vector<Level>& levels, const Field<Real>& x) {
  if (!levels.front().body.config().is_solid()) return 1;
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
double max_stretch(const std::vector<Level>& levels, const Field<Real>& x) {
  double largest = 0;
  for (const auto& [body, first] : levels) {
    body.for_each_spring(
        [&, first = first](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double, double) {
          const double length = (x.at(first + b) - x.at(first + a)).norm();
          largest = std::max(largest, std::abs(spring_strain(length, body.rest_length(slot.kind))));
        });
    largest = body.ranks().largest(largest);
  }
  return largest;
}

template <class Real>
double min_jacobian(const std::vector<Level>& levels, const Field<Real>& x) {
  if (!levels.front().body.config().is_solid()) return 1;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [body, first] : levels) {
    double smallest = std::numeric_limits<double>::infinity();
    body.for_each_cell([&, first = first](std::ptrdiff_t site) {
      const std::array<Vec3, 8> corners = corners_of(body, x, first + site);
      for (int c = 0; c < 8; ++c) smallest = std::min(smallest, corner_volume(corners, c));
    });
    least = std::min(least, -body.ranks().largest(-smallest) / body.cell_volume());
  }
  return least;
}

void Measures::remember(Record& record) {
  record.keep(t, kinetic, elastic, volume_energy, external_potential, volume_ratio, volume_ratio_thesis,
              momentum, angular_momentum, max_speed, max_stretch, min_jacobian, relaxes, relaxing, relaxed);
}

template <class Real>
Measures measure(const SolidSystem<Real>& system, const State<Real>& state) {
  system.update_ghosts(state);
  Measures m;
  m.t = state.t;
  const StoredEnergy energy = system.stored_energy(state.x);
  m.elastic = energy.elastic;
  m.volume_energy = energy.volume;
  m.relaxes = std::any_of(system.levels().begin(), system.levels().end(),
                          [](const Level& level) { return level.body.config().relaxation.acts(); });
  m.relaxing = energy.relaxing;
  m.relaxed = system.dissipated_by_relaxation();
  measure_motion(system, state, m);
  m.max_stretch = max_stretch(system.levels(), state.x);
  m.min_jacobian = min_jacobian(system.levels(), state.x);
  m.volume_ratio = volume_ratio(system.levels(), state.x);
  m.volume_ratio_thesis = thesis_ratio(system.levels(), state.x);
  return m;
}

template double volume_ratio(const std::vector<Level>&, const Field<float>&);
template double volume_ratio(const std::vector<Level>&, const Field<double>&);
template double max_stretch(const std::vector<Level>&, const Field<float>&);
template double max_stretch(const std::vector<Level>&, const Field<double>&);
template double min_jacobian(const std::vector<Level>&, const Field<float>&);
template double min_jacobian(const std::vector<Level>&, const Field<double>&);
template Measures measure(const SolidSystem<float>&, const State<float>&);
template Measures measure(const SolidSystem<double>&, const State<double>&);

}  // namespace mss
