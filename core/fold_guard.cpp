#include "core/fold_guard.hpp"

#include <Eigen/Geometry>

#include "core/cross_matrix.hpp"
#include "core/measures.hpp"

namespace mss {

double fold_guard_energy(double stiffness, double rest_volume, const std::array<Vec3, 8>& corners) {
  double energy = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const double missing = fold_guard_begins - corner_volume(corners, corner) / rest_volume;
    if (!(missing <= 0)) energy += stiffness * rest_volume / 16 * missing * missing;
  }
  return energy;
}

FoldGuardTangent::FoldGuardTangent(double stiffness, double rest_volume, const std::array<Vec3, 8>& corners,
                                   Tangent kind) {
  for (int corner = 0; corner < 8; ++corner) {
    const double missing = fold_guard_begins - corner_volume(corners, corner) / rest_volume;
    if (missing <= 0) continue;
    Near& near = near_[std::size_t(corner)];
    near.stiffness = stiffness / (8 * rest_volume);
    near.pressure = kind == Tangent::projected ? 0 : stiffness / 8 * missing;
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = std::size_t(axis);
      near.side[i] = ((corner >> axis) & 1) == 0 ? 1 : -1;
      near.edge[i] =
          near.side[i] * (corners[std::size_t(corner ^ (1 << axis))] - corners[std::size_t(corner)]);
    }
    near.gradient[0] = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      near.gradient[i + 1] = near.side[i] * near.edge[(i + 1) % 3].cross(near.edge[(i + 2) % 3]);
      near.gradient[0] -= near.gradient[i + 1];
    }
  }
}

// D = e_x . (e_y x e_z): d^2D / de_x de_y = -[e_z]x, and so on around; by itself no edge bends it.
Eigen::Matrix3d FoldGuardTangent::Near::block(int a, int b) const {
  Eigen::Matrix3d k = stiffness * gradient[std::size_t(a)] * gradient[std::size_t(b)].transpose();
  if (pressure == 0) return k;
  const auto moves = [&](int node, std::size_t i) {  // how edge i changes when the node moves
    return node == 0 ? -side[i] : node == int(i) + 1 ? side[i] : 0;
  };
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double weight = i == j ? 0 : moves(a, i) * moves(b, j);
      if (weight == 0) continue;
      const std::size_t third = 3 - i - j;
      const double sign = j == (i + 1) % 3 ? -1 : 1;
      k -= pressure * weight * sign * cross_matrix(edge[third]);
    }
  return k;
}

}  // namespace mss
