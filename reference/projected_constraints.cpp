#include "reference/projected_constraints.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace mss::reference {

namespace {

/// The order of a cell's springs, of integrators/position_based/xpbd_loops.hpp.
constexpr int order[] = {3, 10, 11, 4, 12, 5, 7, 9, 0, 8, 1, 2, 6};

/// 1 or -1: on which side of the cell's middle a corner is.
double side(int corner, int axis) { return ((corner >> axis) & 1) != 0 ? 1 : -1; }

}  // namespace

ProjectedConstraints::ProjectedConstraints(const Body& body, std::vector<double> inverse_mass, double dt)
    : body_(body), inverse_mass_(std::move(inverse_mass)), dt_(dt) {
  const Lattice& lattice = body.lattice();
  for (int colour = 0; colour < 8; ++colour)
    for (int k = colour >> 2; k <= lattice.cells[2]; k += 2)
      for (int j = (colour >> 1) & 1; j <= lattice.cells[1]; j += 2)
        for (int i = colour & 1; i <= lattice.cells[0]; i += 2) {
          const std::ptrdiff_t site = lattice.site(i, j, k);
          const SiteElements e = body.elements_at(site);
          Cell cell{site, e.volume, 0, {}};
          for (const int s : order) {
            const SpringSlot& slot = spring_slots[std::size_t(s)];
            if (e.stiffness[std::size_t(s)] > 0)
              cell.springs.push_back({site + lattice.corner(slot.a), site + lattice.corner(slot.b),
                                      e.stiffness[std::size_t(s)], e.damping[std::size_t(s)],
                                      body.rest_length(slot.kind), 0});
          }
          cells_.push_back(std::move(cell));
        }
}

void ProjectedConstraints::forget() {
  for (Cell& cell : cells_) {
    cell.multiplier = 0;
    for (Spring& spring : cell.springs) spring.multiplier = 0;
  }
}

void ProjectedConstraints::project(const Field<double>& x, Field<double>& u) {
  for (Cell& cell : cells_) {
    if (cell.volume_stiffness > 0) project_volume(cell, x, u);
    for (Spring& spring : cell.springs) project_spring(spring, x, u);
  }
}

/// Thesis eq. 3-5 to 3-7: the volume of the parallelepiped of the mean edges.
void ProjectedConstraints::project_volume(Cell& cell, const Field<double>& x, Field<double>& u) const {
  Eigen::Matrix3d edges = Eigen::Matrix3d::Zero();
  for (int c = 0; c < 8; ++c) {
    const std::ptrdiff_t at = cell.site + body_.lattice().corner(c);
    for (int axis = 0; axis < 3; ++axis) edges.col(axis) += side(c, axis) / 4 * (x.at(at) + u.at(at));
  }
  const Vec3 yz = edges.col(1).cross(edges.col(2)), zx = edges.col(2).cross(edges.col(0)),
             xy = edges.col(0).cross(edges.col(1));
  const double rest = body_.cell_volume(), excess = edges.col(0).dot(yz) - rest;
  const double compliance = rest / (cell.volume_stiffness * dt_ * dt_);
  double mobility = 0;
  std::array<Vec3, 8> slope;
  for (int c = 0; c < 8; ++c) {
    slope[std::size_t(c)] = (side(c, 0) * yz + side(c, 1) * zx + side(c, 2) * xy) / 4;
    mobility += inverse_mass_[std::size_t(cell.site + body_.lattice().corner(c))] *
                slope[std::size_t(c)].squaredNorm();
  }
  const double change = -(excess + compliance * cell.multiplier) / (mobility + compliance);
  cell.multiplier += change;
  for (int c = 0; c < 8; ++c) {
    const std::ptrdiff_t at = cell.site + body_.lattice().corner(c);
    u.set(at, u.at(at) + inverse_mass_[std::size_t(at)] * change * slope[std::size_t(c)]);
  }
}

void ProjectedConstraints::project_spring(Spring& s, const Field<double>& x, Field<double>& u) const {
  const Vec3 d = x.at(s.a) + u.at(s.a) - x.at(s.b) - u.at(s.b), n = d.normalized();
  const double compliance = 1 / (s.stiffness * dt_ * dt_), damping = s.damping / (s.stiffness * dt_);
  const double w_a = inverse_mass_[std::size_t(s.a)], w_b = inverse_mass_[std::size_t(s.b)];
  const double change =
      -(d.norm() - s.rest_length + compliance * s.multiplier + damping * n.dot(u.at(s.a) - u.at(s.b))) /
      ((1 + damping) * (w_a + w_b) + compliance);
  s.multiplier += change;
  u.set(s.a, u.at(s.a) + w_a * change * n);
  u.set(s.b, u.at(s.b) - w_b * change * n);
}

}  // namespace mss::reference
