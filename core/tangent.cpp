#include "core/tangent.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace mss {

namespace {

Vec3 sides(int corner) {
  return {(corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0, (corner & 4) != 0 ? 1.0 : -1.0};
}

Eigen::Matrix3d cross_matrix(const Vec3& a) {
  Eigen::Matrix3d m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

/// Offset from one corner of a cell to another, as a number from 0 to 26; 13 is none.
int offset_index(int from, int to) {
  const auto along = [&](int axis) { return ((to >> axis) & 1) - ((from >> axis) & 1) + 1; };
  return along(0) + 3 * along(1) + 9 * along(2);
}

using Block = Eigen::Map<Eigen::Matrix3d>;

}  // namespace

SpringTangent spring_tangent(double k, double c, double rest_length, const Vec3& d, const Vec3& w,
                             Tangent kind) {
  const double length = std::max(d.norm(), std::numeric_limits<double>::min());
  const Vec3 u = d / length;
  const Eigen::Matrix3d along = u * u.transpose();
  double across = k * (1 - rest_length / length);
  if (kind == Tangent::projected) across = std::max(0.0, across);
  SpringTangent tangent{(k - across) * along, c * along};
  if (kind == Tangent::exact && c != 0) {
    const double rate = w.dot(u);
    across += c * rate / length;
    tangent.stiffness = (k - across) * along + (c / length) * u * (w - rate * u).transpose();
  }
  tangent.stiffness.diagonal().array() += across;
  return tangent;
}

CellTangent::CellTangent(double k_vol, double rest_volume, const std::array<Vec3, 8>& corners, Tangent kind)
    : stiffness_(k_vol / rest_volume), mean_edges_(Eigen::Matrix3d::Zero()) {
  for (int c = 0; c < 8; ++c) mean_edges_ += corners[std::size_t(c)] * sides(c).transpose() / 4;
  const Vec3 x = mean_edges_.col(0), y = mean_edges_.col(1), z = mean_edges_.col(2);
  Eigen::Matrix3d faces;
  faces << y.cross(z), z.cross(x), x.cross(y);
  for (int c = 0; c < 8; ++c) gradient_[std::size_t(c)] = faces * sides(c) / 4;
  pressure_ = stiffness_ * (x.dot(faces.col(0)) - rest_volume);
  if (kind == Tangent::projected) {
    stiffness_ = std::max(0.0, stiffness_);
    pressure_ = 0;
  }
}

Eigen::Matrix3d CellTangent::block(int c, int d) const {
  Eigen::Matrix3d k = stiffness_ * gradient_[std::size_t(c)] * gradient_[std::size_t(d)].transpose();
  if (pressure_ != 0) k -= cross_matrix(pressure_ / 16 * mean_edges_ * sides(c).cross(sides(d)));
  return k;
}

TangentAssembler::TangentAssembler(const Body& body, const HeldSites& held) : body_(body) {
  id_.assign(std::size_t(body.lattice().size), -1);
  for (std::size_t p = 0; p < body.sites().size(); ++p) id_[std::size_t(body.sites()[p])] = int(p);
  find_neighbours();
  build_pattern(held);
}

/// Particles are neighbours if they share a cell. Offsets ascend as sites do, so blocks of a row are sorted.
void TangentAssembler::find_neighbours() {
  const Lattice& lattice = body_.lattice();
  std::vector<bool> meets(body_.particle_count() * neighbours, false);
  body_.for_each_cell([&](std::ptrdiff_t site) {
    for (int c = 0; c < 8; ++c)
      for (int d = 0; d < 8; ++d)
        meets[std::size_t(id_[std::size_t(site + lattice.corner(c))]) * neighbours +
              std::size_t(offset_index(c, d))] = true;
  });
  block_.assign(meets.size(), -1);
  block_start_.assign(1, 0);
  for (std::size_t p = 0; p < body_.particle_count(); ++p) {
    for (std::size_t o = 0; o < neighbours; ++o) {
      if (!meets[p * neighbours + o]) continue;
      const auto i = std::ptrdiff_t(o) % 3 - 1, j = std::ptrdiff_t(o) / 3 % 3 - 1,
                 k = std::ptrdiff_t(o) / 9 - 1;
      block_[p * neighbours + o] = int(column_.size());
      column_.push_back(id_[std::size_t(body_.sites()[p] + i + lattice.row * j + lattice.plane * k)]);
    }
    block_start_.push_back(int(column_.size()));
  }
}

void TangentAssembler::build_pattern(const HeldSites& held) {
  std::vector<int> unknown_of(3 * body_.particle_count(), -1);
  for (std::size_t p = 0; p < body_.particle_count(); ++p)
    for (int axis = 0; axis < 3; ++axis)
      if (const std::ptrdiff_t site = body_.sites()[p]; !held.holds(site, axis)) {
        unknown_of[3 * p + std::size_t(axis)] = int(unknowns_.size());
        unknowns_.push_back({site, axis});
      }
  std::vector<int> start{0}, inner;
  for (const Unknown& row : unknowns_) {
    const auto p = std::size_t(id_[std::size_t(row.site)]);
    for (int b = block_start_[p]; b < block_start_[p + 1]; ++b)
      for (int axis = 0; axis < 3; ++axis) {
        const int column = unknown_of[3 * std::size_t(column_[std::size_t(b)]) + std::size_t(axis)];
        if (column < 0) continue;
        inner.push_back(column);
        source_.push_back(9 * b + row.axis + 3 * axis);
      }
    start.push_back(int(inner.size()));
  }
  const auto size = Eigen::Index(unknowns_.size());
  const std::vector<double> zeros(inner.size(), 0.0);
  pattern_ = Eigen::Map<const SparseMatrix>(size, size, Eigen::Index(inner.size()), start.data(),
                                            inner.data(), zeros.data());
  numbers_.resize(9 * column_.size());
}

/// Calls add(site, corner, other corner, block) for every pair of corners that a spring or cell joins.
template <class Real, class Add>
void TangentAssembler::for_each_element(const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                                        Add&& add) const {
  const Lattice& lattice = body_.lattice();
  for (std::ptrdiff_t site = 0; site < lattice.sites; ++site) {
    const SiteElements& e = body_.elements_at(site);
    for (std::size_t s = 0; s < spring_slots.size(); ++s) {
      if (e.stiffness[s] == 0) continue;
      const auto [a, b, kind] = spring_slots[s];
      const std::ptrdiff_t i = site + lattice.corner(a), j = site + lattice.corner(b);
      const SpringTangent tangent = spring_tangent(e.stiffness[s], e.damping[s], body_.rest_length(kind),
                                                   x.at(j) - x.at(i), v.at(j) - v.at(i), sum.kind);
      const Eigen::Matrix3d block = sum.stiffness * tangent.stiffness + sum.damping * tangent.damping;
      add(site, a, a, block);
      add(site, b, b, block);
      add(site, a, b, -block);
      add(site, b, a, -block);
    }
    if (e.volume == 0) continue;
    std::array<Vec3, 8> corners;
    for (int c = 0; c < 8; ++c) corners[std::size_t(c)] = x.at(site + lattice.corner(c));
    const CellTangent tangent(sum.stiffness * e.volume, body_.cell_volume(), corners, sum.kind);
    for (int c = 0; c < 4; ++c)  // opposite corners have opposite gradients
      for (int d = 0; d < 4; ++d) {
        const Eigen::Matrix3d block = tangent.block(c, d);
        add(site, c, d, block);
        add(site, 7 - c, 7 - d, block);
        add(site, c, 7 - d, -block);
        add(site, 7 - c, d, -block);
      }
  }
}

int TangentAssembler::block_index(std::ptrdiff_t site, int from_corner, int to_corner) const {
  const int p = id_[std::size_t(site + body_.lattice().corner(from_corner))];
  return block_[std::size_t(p) * neighbours + std::size_t(offset_index(from_corner, to_corner))];
}

template <class Real>
void TangentAssembler::write(const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                             SparseMatrix& matrix) {
  std::fill(numbers_.begin(), numbers_.end(), 0.0);
  for_each_element(x, v, sum, [&](std::ptrdiff_t site, int c, int d, const Eigen::Matrix3d& block) {
    Block(numbers_.data() + 9 * std::size_t(block_index(site, c, d))) += block;
  });
  for (std::size_t p = 0; p < body_.particle_count(); ++p) {
    const int diagonal = block_[p * neighbours + neighbours / 2];
    Block(numbers_.data() + 9 * std::size_t(diagonal)).diagonal().array() +=
        sum.mass * body_.mass(body_.sites()[p]);
  }
  for (std::size_t i = 0; i < source_.size(); ++i) matrix.valuePtr()[i] = numbers_[std::size_t(source_[i])];
}

template <class Real>
void TangentAssembler::write_diagonal(const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                                      std::vector<Eigen::Matrix3d>& blocks) const {
  blocks.resize(body_.particle_count());
  for (std::size_t p = 0; p < blocks.size(); ++p)
    blocks[p] = sum.mass * body_.mass(body_.sites()[p]) * Eigen::Matrix3d::Identity();
  for_each_element(x, v, sum, [&](std::ptrdiff_t site, int c, int d, const Eigen::Matrix3d& block) {
    if (c == d) blocks[std::size_t(id_[std::size_t(site + body_.lattice().corner(c))])] += block;
  });
}

template void TangentAssembler::write(const Field<float>&, const Field<float>&, const TangentSum&,
                                      SparseMatrix&);
template void TangentAssembler::write(const Field<double>&, const Field<double>&, const TangentSum&,
                                      SparseMatrix&);
template void TangentAssembler::write_diagonal(const Field<float>&, const Field<float>&, const TangentSum&,
                                               std::vector<Eigen::Matrix3d>&) const;
template void TangentAssembler::write_diagonal(const Field<double>&, const Field<double>&, const TangentSum&,
                                               std::vector<Eigen::Matrix3d>&) const;

}  // namespace mss
