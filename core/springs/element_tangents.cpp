#include "core/springs/element_tangents.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/forces/cell_geometry.hpp"
#include "core/forces/cross_matrix.hpp"
#include "core/forces/fold_guard.hpp"
#include "core/forces/spring_law.hpp"

namespace mss {

SpringTangent spring_tangent(double k, double c, double rest_length, const Vec3& d, const Vec3& w,
                             Tangent kind) {
  constexpr double shortest =
      1e-9;  // of the rest length: the transverse stiffness of a spring of no length is unbounded
  const double length = std::max(d.norm(), shortest * rest_length);
  const Vec3 u = d / length;
  const Eigen::Matrix3d along = u * u.transpose();
  const double ratio = rest_length / length, k_along = spring_stiffness(k, ratio);
  double across = tension_over_length(k, ratio);
  if (kind == Tangent::projected) across = std::max(0.0, across);
  SpringTangent tangent{(k_along - across) * along, c * along};
  if (kind == Tangent::exact && c != 0) {
    const double rate = w.dot(u);
    across += c * rate / length;
    tangent.stiffness = (k_along - across) * along + (c / length) * u * (w - rate * u).transpose();
  }
  tangent.stiffness.diagonal().array() += across;
  return tangent;
}

CellTangent::CellTangent(double k_vol, double rest_volume, const std::array<Vec3, 8>& corners, Tangent kind)
    : stiffness_(k_vol / rest_volume), mean_edges_(mean_edges(corners)) {
  const Eigen::Matrix3d slopes = volume_slopes(mean_edges_);
  for (int c = 0; c < 8; ++c) gradient_[std::size_t(c)] = slopes * corner_sides(c) / 4;
  pressure_ = stiffness_ * (mean_edges_.col(0).dot(slopes.col(0)) - rest_volume);
  if (kind == Tangent::projected) {
    stiffness_ = std::max(0.0, stiffness_);
    pressure_ = 0;
  }
}

Eigen::Matrix3d CellTangent::block(int c, int d) const {
  Eigen::Matrix3d k = stiffness_ * gradient_[std::size_t(c)] * gradient_[std::size_t(d)].transpose();
  if (pressure_ != 0)
    k -= cross_matrix(pressure_ / 16 * mean_edges_ * corner_sides(c).cross(corner_sides(d)));
  return k;
}

namespace {

template <class Real, class Add>
void add_springs(const Body& body, std::ptrdiff_t site, const Field<Real>& x, const Field<Real>& v,
                 const TangentCoefficients& sum, Add&& add) {
  if (body.kind(site) == 0) return;
  const SiteElements e = body.elements_at(site);
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    if (e.stiffness[s] == 0) continue;
    const auto [a, b, kind] = spring_slots[s];
    const std::ptrdiff_t i = site + body.lattice().corner(a), j = site + body.lattice().corner(b);
    const SpringTangent tangent = spring_tangent(e.stiffness[s], e.damping[s], body.rest_length(kind),
                                                 x.at(j) - x.at(i), v.at(j) - v.at(i), sum.kind);
    const Eigen::Matrix3d block = sum.stiffness * tangent.stiffness + sum.damping * tangent.damping;
    add(site, a, a, block);
    add(site, b, b, block);
    add(site, a, b, -block);
    add(site, b, a, -block);
  }
}

/// Its volume force and its guard against folding.
template <class Real, class Add>
void add_cell(const Body& body, std::ptrdiff_t site, const Field<Real>& x, const TangentCoefficients& sum,
              Add&& add) {
  const SiteWeights& weights = body.weights_at(site);
  if (weights.volume == 0 && weights.fold_guard == 0) return;  // no cell, whatever 0 times the rest is
  const double volume = weights.volume * body.kinds().interior_volume(),
               guard = weights.fold_guard * body.kinds().interior_fold_guard(),
               size = body.config().cell_size;
  if (guard != 0)
    FoldGuardTangent(sum.stiffness * guarded_corner_stiffness(guard, size), guarded_length(size),
                     corners_of(body, x, site), sum.kind)
        .for_each_block([&](int c, int d, const Eigen::Matrix3d& block) { add(site, c, d, block); });
  if (volume == 0) return;
  const CellTangent tangent(sum.stiffness * volume, body.cell_volume(), corners_of(body, x, site), sum.kind);
  for (int c = 0; c < 4; ++c)  // opposite corners have opposite gradients
    for (int d = 0; d < 4; ++d) {
      const Eigen::Matrix3d block = tangent.block(c, d);
      add(site, c, d, block);
      add(site, 7 - c, 7 - d, block);
      add(site, c, 7 - d, -block);
      add(site, 7 - c, d, -block);
    }
}

}  // namespace

template <class Real>
void for_each_tangent_block(const Body& body, std::ptrdiff_t site, const Field<Real>& x, const Field<Real>& v,
                            const TangentCoefficients& sum, const AddBlock& add) {
  add_springs(body, site, x, v, sum, add);
  add_cell(body, site, x, sum, add);
}

template <class Real>
void add_tangent(const Body& body, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                 BlockMatrix& blocks) {
  const auto add = [&](std::ptrdiff_t site, int c, int d, const Eigen::Matrix3d& block) {
    blocks.add(site, c, d, block);
  };
  for (std::ptrdiff_t site = 0; site < body.lattice().sites; ++site) {
    add_springs(body, site, x, v, sum, add);
    add_cell(body, site, x, sum, add);
  }
}

template void for_each_tangent_block(const Body&, std::ptrdiff_t, const Field<float>&, const Field<float>&,
                                     const TangentCoefficients&, const AddBlock&);
template void for_each_tangent_block(const Body&, std::ptrdiff_t, const Field<double>&, const Field<double>&,
                                     const TangentCoefficients&, const AddBlock&);
template void add_tangent(const Body&, const Field<float>&, const Field<float>&, const TangentCoefficients&,
                          BlockMatrix&);
template void add_tangent(const Body&, const Field<double>&, const Field<double>&, const TangentCoefficients&,
                          BlockMatrix&);

}  // namespace mss
