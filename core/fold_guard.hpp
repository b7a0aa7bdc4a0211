#pragma once

#include <Eigen/Core>
#include <array>

#include "core/system.hpp"

namespace mss {

/// Below this share of its volume at rest, a corner of a cell is near folding.
inline constexpr double fold_guard_begins = 0.4;

/// Energy that keeps a cell from folding [J]. Springs see lengths only, to them a mirror image is at rest.
/// Of every corner, with D the signed volume of its three edges, V0 the cell's volume at rest and k_g the
/// guard's stiffness [Pa]:
///   E = k_g V0 / 16 (0.4 - D / V0)^2 where D / V0 < 0.4, else exactly 0.
double fold_guard_energy(double stiffness, double rest_volume, const std::array<Vec3, 8>& corners);

/// Second derivatives of that energy by the corners' positions. With g_c = dD/dx_c and q = k_g / 8 (0.4 -
/// D / V0), of every corner near folding: k_g / (8 V0) g_c g_c'^T - q d^2D/dx_c dx_c'. The projected form
/// leaves out the second term.
class FoldGuardTangent {
 public:
  FoldGuardTangent(double stiffness, double rest_volume, const std::array<Vec3, 8>& corners, Tangent kind);

  /// Calls add(c, d, block) for every pair of corners with a block that may not be zero.
  template <class Add>
  void for_each_block(Add&& add) const {
    for (int corner = 0; corner < 8; ++corner) {
      const Near& near = near_[std::size_t(corner)];
      if (near.stiffness == 0) continue;
      const std::array<int, 4> at{corner, corner ^ 1, corner ^ 2, corner ^ 4};
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) add(at[std::size_t(a)], at[std::size_t(b)], near.block(a, b));
    }
  }

 private:
  /// A corner, and what its volume does when it (0) or its neighbours along x, y, z (1 to 3) move.
  struct Near {
    double stiffness = 0;  ///< 0: far from folding
    double pressure = 0;
    std::array<Vec3, 4> gradient;
    std::array<Vec3, 3> edge;
    std::array<double, 3> side;  ///< +1 where the edge leads away from the corner
    Eigen::Matrix3d block(int a, int b) const;
  };
  std::array<Near, 8> near_;
};

}  // namespace mss
