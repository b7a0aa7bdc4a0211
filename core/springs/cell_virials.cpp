#include "core/springs/cell_virials.hpp"

#include <algorithm>

#include "core/body/cell_springs.hpp"
#include "core/forces/cell_geometry.hpp"
#include "core/forces/fold_guard.hpp"
#include "core/forces/spring_law.hpp"

namespace mss {

namespace {

/// T d d^T / L of a cell's springs, with their dampers' force in T.
Eigen::Matrix3d virial_of_springs(const CellSprings::Springs& springs, const BodyConfig& config,
                                  const std::array<Vec3, 8>& x, const std::array<Vec3, 8>& v) {
  constexpr double shortest = 1e-9;  // of the rest length: the direction of a spring of no length is none
  Eigen::Matrix3d virial = Eigen::Matrix3d::Zero();
  for (const CellSpring& spring : springs) {
    if (spring.stiffness == 0) continue;
    const auto a = std::size_t(spring.a), b = std::size_t(spring.b);
    const double rest_length = config.rest_length(spring.kind);
    const Vec3 d = x[b] - x[a];
    const double length = std::max(d.norm(), shortest * rest_length);
    const double over_length = tension_over_length(spring.stiffness, rest_length / length) +
                               spring.damping * (v[b] - v[a]).dot(d) / (length * length);
    virial += over_length * d * d.transpose();
  }
  return virial;
}

/// The gradient of k_vol (V - V0)^2 / (2 V0) by the corners, times these: the volume V of mean edges is
/// homogeneous of degree one in each of them, and the sum of dV/dx x^T is V I.
Eigen::Matrix3d virial_of_volume(double k_vol, double rest_volume, const std::array<Vec3, 8>& x) {
  const double volume = thesis_volume(x);
  return k_vol * (volume - rest_volume) / rest_volume * volume * Eigen::Matrix3d::Identity();
}

}  // namespace

template <class Real>
void append_virials(const Level& level, const Field<Real>& x, const Field<Real>& v,
                    std::vector<Eigen::Matrix3d>& virials) {
  const auto& [body, first] = level;
  const BodyConfig& config = body.config();
  CellSprings springs(body);
  body.for_each_cell([&](std::ptrdiff_t site) {
    const std::array<Vec3, 8> corners = corners_of(body, x, first + site);
    const SiteWeights& weights = body.weights_at(site);
    const double guard = weights.fold_guard * body.kinds().interior_fold_guard();
    virials.push_back(
        virial_of_springs(springs.at(site), config, corners, corners_of(body, v, first + site)) +
        virial_of_volume(weights.volume * body.kinds().interior_volume(), body.cell_volume(), corners));
    if (guard != 0)
      virials.back() += fold_guard_virial(guarded_corner_stiffness(guard, config.cell_size),
                                          guarded_length(config.cell_size), corners);
  });
}

template void append_virials(const Level&, const Field<float>&, const Field<float>&,
                             std::vector<Eigen::Matrix3d>&);
template void append_virials(const Level&, const Field<double>&, const Field<double>&,
                             std::vector<Eigen::Matrix3d>&);

}  // namespace mss
