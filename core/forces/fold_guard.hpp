#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <limits>

#include "core/system/tangents.hpp"

namespace mss {

/// Principal stretches of a guarded cell of edge h [m] are resisted below this length [m].
constexpr double guarded_length(double h) { return 0.7 * h; }

/// Largest stiffness [N/m] with which a corner of a cell of edge h [m], guarded with k_g [Pa], resists.
constexpr double guarded_corner_stiffness(double k_g, double h) { return k_g * h / 8; }

/// One corner of a cell in the principal stretches s of its three edges, F = [x y z] = U diag(s) V^T with
/// rotations U and V, s_0 >= s_1 >= |s_2|: s_2 is negative where the corner is inverted (Irving, Teran and
/// Fedkiw, Invertible finite elements, 2004, section 4). All are lengths [m].
///
/// Its energy keeps cells from folding; springs depend on lengths only, so a mirrored cell is at rest. Of
/// every corner, with h the cell's edge at rest and k_g the guard's stiffness [Pa]:
///   E = k_g h / 16 sum_i max(0, 0.7 h - s_i)^2.
/// E is continuous; where s_1 + s_2 = 0, the nearer of two mirror images changes, and the force is
/// discontinuous.
class GuardedCorner {
 public:
  /// `stiffness` guarded_corner_stiffness(), `shortest` guarded_length().
  GuardedCorner(double stiffness, double shortest, const Eigen::Matrix3d& edges);

  /// Whether any stretch may be below `shortest`: then the volume D = det F is at most the largest of
  /// shortest^3 and shortest (|F|^2 - shortest^2) / 2, as s_0 s_1 <= (s_0^2 + s_1^2) / 2. False for edges
  /// that are not finite.
  static bool may_act(double shortest, const Eigen::Matrix3d& edges);

  double energy() const;         ///< [J]
  Eigen::Matrix3d pull() const;  ///< by edge, -dE/dF [N]
  /// How the pull changes, to first order, along a change of the edges. The elastic one is singular where
  /// s_1 + s_2 = 0, there its last term is bounded; the projected one leaves it out.
  Eigen::Matrix3d pull_change(const Eigen::Matrix3d& change, Tangent kind) const;

 private:
  double slope(int i) const { return stiffness_ * std::min(stretch_[i] - shortest_, 0.0); }  ///< dE/ds_i

  double stiffness_, shortest_;
  Eigen::Matrix3d u_ = Eigen::Matrix3d::Identity(), v_ = u_;
  Eigen::Vector3d stretch_ = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
};

/// The energy of a cell's eight corners [J].
double fold_guard_energy(double stiffness, double shortest, const std::array<Vec3, 8>& corners);

/// The sum of its derivatives by the corners times these, dE/dx x^T [J]; symmetric.
Eigen::Matrix3d fold_guard_virial(double stiffness, double shortest, const std::array<Vec3, 8>& corners);

/// Second derivatives of that energy by the corners' positions.
class FoldGuardTangent {
 public:
  FoldGuardTangent(double stiffness, double shortest, const std::array<Vec3, 8>& corners, Tangent kind);

  /// Calls add(c, d, block) for every pair of corners with a block that may not be zero.
  template <class Add>
  void for_each_block(Add&& add) const {
    for (int corner = 0; corner < 8; ++corner) {
      if (!acts_[std::size_t(corner)]) continue;
      const std::array<int, 4> at{corner, corner ^ 1, corner ^ 2, corner ^ 4};
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) add(at[std::size_t(a)], at[std::size_t(b)], block(corner, a, b));
    }
  }

 private:
  /// Of a corner (0) and its neighbours along x, y, z (1 to 3).
  Eigen::Matrix3d block(int corner, int a, int b) const;

  std::array<bool, 8> acts_{};
  /// -d pull / d edges: rows 3 i to 3 i + 2 are edge i's.
  std::array<Eigen::Matrix<double, 9, 9>, 8> by_edges_;
};

}  // namespace mss
