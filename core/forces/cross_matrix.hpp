#pragma once

#include "core/base/field.hpp"

namespace mss {

/// [a]x, with [a]x b = a x b.
inline Eigen::Matrix3d cross_matrix(const Vec3& a) {
  Eigen::Matrix3d m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

}  // namespace mss
