#include "core/forces/fold_guard.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/base/lattice.hpp"
#include "core/forces/cell_fold_guard.hpp"

namespace mss {

namespace {

/// The three edges at a corner, each in the direction of its axis.
template <class Corners>
Eigen::Matrix3d edges_at(const Corners& corners, int corner) {
  Eigen::Matrix3d edges;
  for (int axis = 0; axis < 3; ++axis)
    for (int a = 0; a < 3; ++a) {
      const auto lower = std::size_t(corner & ~(1 << axis)), upper = std::size_t(corner | 1 << axis);
      edges(a, axis) = corners[upper][a] - corners[lower][a];
    }
  return edges;
}

/// Pulls the three edges at a corner: their upper ends one way, their lower ends the other.
void stretch(int corner, const Eigen::Matrix3d& pull, double (&force)[8][3]) {
  for (int axis = 0; axis < 3; ++axis)
    for (int a = 0; a < 3; ++a) {
      force[corner | 1 << axis][a] += pull(a, axis);
      force[corner & ~(1 << axis)][a] -= pull(a, axis);
    }
}

/// Calls act(corner, guarded) for every corner of a cell that its guard may act on.
template <class Corners, class Act>
void for_each_guarded(double stiffness, double shortest, const Corners& corners, Act&& act) {
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Matrix3d edges = edges_at(corners, corner);
    if (GuardedCorner::may_act(shortest, edges)) act(corner, GuardedCorner(stiffness, shortest, edges));
  }
}

}  // namespace

GuardedCorner::GuardedCorner(double stiffness, double shortest, const Eigen::Matrix3d& edges)
    : stiffness_(stiffness), shortest_(shortest) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(edges, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.info() != Eigen::Success) return;  // edges that are not finite: nothing is short
  u_ = svd.matrixU();
  v_ = svd.matrixV();
  stretch_ = svd.singularValues();
  const auto turn = [&](Eigen::Matrix3d& mirrored) {  // into a rotation
    if (mirrored.determinant() > 0) return;
    mirrored.col(2) *= -1;
    stretch_[2] *= -1;
  };
  turn(u_);
  turn(v_);
}

bool GuardedCorner::may_act(double shortest, const Eigen::Matrix3d& edges) {
  const double squared = edges.squaredNorm(), volume = edges.determinant();
  const double bound = shortest * std::max(shortest * shortest, 0.5 * (squared - shortest * shortest));
  return std::isfinite(squared) && volume <= bound;
}

double GuardedCorner::energy() const {
  double energy = 0;
  for (int i = 0; i < 3; ++i) energy += 0.5 * slope(i) * std::min(stretch_[i] - shortest_, 0.0);
  return energy;
}

Eigen::Matrix3d GuardedCorner::pull() const {
  return u_ * Eigen::Vector3d(-slope(0), -slope(1), -slope(2)).asDiagonal() * v_.transpose();
}

// In the frames of U and V, dF has a part that stretches (its diagonal), and for every two axes one that
// shears and one that turns: Smith, de Goes and Kim, Analytic eigensystems for isotropic distortion energies,
// 2019, section 4.
Eigen::Matrix3d GuardedCorner::pull_change(const Eigen::Matrix3d& change, Tangent kind) const {
  constexpr double least_sum = 1e-3;  // of the shortest stretch
  const Eigen::Matrix3d d = u_.transpose() * change * v_;
  Eigen::Matrix3d p = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    if (stretch_[i] < shortest_) p(i, i) = -stiffness_ * d(i, i);
    for (int j = i + 1; j < 3; ++j) {
      const bool both = stretch_[i] < shortest_, one = stretch_[j] < shortest_;  // s_i >= s_j
      const double shear = both ? stiffness_ : one ? -slope(j) / (stretch_[i] - stretch_[j]) : 0;
      const double sum = std::max(stretch_[i] + stretch_[j], least_sum * shortest_);
      const double turn = kind == Tangent::projected ? 0 : (slope(i) + slope(j)) / sum;
      const double even = 0.5 * shear * (d(i, j) + d(j, i)), odd = 0.5 * turn * (d(i, j) - d(j, i));
      p(i, j) = -(even + odd);
      p(j, i) = -(even - odd);
    }
  }
  return u_ * p * v_.transpose();
}

double fold_guard_energy(double stiffness, double shortest, const std::array<Vec3, 8>& corners) {
  double energy = 0;
  for_each_guarded(stiffness, shortest, corners,
                   [&](int, const GuardedCorner& guarded) { energy += guarded.energy(); });
  return energy;
}

Eigen::Matrix3d fold_guard_virial(double stiffness, double shortest, const std::array<Vec3, 8>& corners) {
  Eigen::Matrix3d virial = Eigen::Matrix3d::Zero();
  for_each_guarded(stiffness, shortest, corners, [&](int corner, const GuardedCorner& guarded) {
    virial -= guarded.pull() * edges_at(corners, corner).transpose();
  });
  return virial;
}

void add_fold_guard_force(double stiffness, double shortest, const double (&corners)[8][3],
                          double (&force)[8][3]) {
  for_each_guarded(stiffness, shortest, corners,
                   [&](int corner, const GuardedCorner& guarded) { stretch(corner, guarded.pull(), force); });
}

void add_fold_guard_change(double stiffness, double shortest, const double (&corners)[8][3],
                           const double (&directions)[8][3], bool projected, double (&change)[8][3]) {
  const Tangent kind = projected ? Tangent::projected : Tangent::elastic;
  for_each_guarded(stiffness, shortest, corners, [&](int corner, const GuardedCorner& guarded) {
    stretch(corner, guarded.pull_change(edges_at(directions, corner), kind), change);
  });
}

void add_fold_guard_diagonal(double stiffness, double shortest, const double (&corners)[8][3], bool projected,
                             double (&blocks)[8][6]) {
  std::array<Vec3, 8> at;
  for (std::size_t c = 0; c < 8; ++c) at[c] = Vec3(corners[c][0], corners[c][1], corners[c][2]);
  FoldGuardTangent(stiffness, shortest, at, projected ? Tangent::projected : Tangent::elastic)
      .for_each_block([&](int c, int d, const Eigen::Matrix3d& block) {
        if (c != d) return;
        for (int a = 0; a < 3; ++a) {
          blocks[c][a] += block(a, a);
          blocks[c][3 + a] += block((a + 1) % 3, (a + 2) % 3);
        }
      });
}

FoldGuardTangent::FoldGuardTangent(double stiffness, double shortest, const std::array<Vec3, 8>& corners,
                                   Tangent kind) {
  for_each_guarded(stiffness, shortest, corners, [&](int at, const GuardedCorner& guarded) {
    const auto corner = std::size_t(at);
    acts_[corner] = true;
    for (int k = 0; k < 9; ++k) {
      Eigen::Matrix3d unit = Eigen::Matrix3d::Zero();
      unit(k % 3, k / 3) = 1;
      const Eigen::Matrix3d pull = guarded.pull_change(unit, kind);
      by_edges_[corner].col(k) = -pull.reshaped();
    }
  });
}

Eigen::Matrix3d FoldGuardTangent::block(int corner, int a, int b) const {
  const auto moves = [&](int node, int axis) {  // how an edge changes when the node moves
    const int side = -corner_sign(corner, axis);
    return node == 0 ? -side : node == axis + 1 ? side : 0;
  };
  Eigen::Matrix3d k = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (const int weight = moves(a, i) * moves(b, j); weight != 0)
        k += weight * by_edges_[std::size_t(corner)].block<3, 3>(Eigen::Index{3} * i, Eigen::Index{3} * j);
  return k;
}

}  // namespace mss
