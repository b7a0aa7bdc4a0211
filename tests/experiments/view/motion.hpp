#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "experiments/view/drawn_surface.hpp"

namespace mss::testing {

inline Vec3 as_vec3(const std::array<float, 3>& p) { return {p[0], p[1], p[2]}; }

/// That what motion() says moves the vertices as update(x, values) has; lengths are about 1.
inline void expect_motion_is_that_of_update(const view::DrawnSurface& surface, const Field<double>& x,
                                            const std::vector<float>& values) {
  const auto motion = surface.motion();
  ASSERT_TRUE(motion);
  const std::vector<view::SurfaceVertex>& expected = surface.vertices();
  std::vector<Vec3> points;
  for (std::size_t v = 0; v < expected.size(); ++v) {
    Vec3 at = Vec3::Zero();
    double value = 0;
    for (const auto& [entry, weight] : motion->shares[v]) {
      at += weight * x.at(surface.sites()[entry]);
      value += weight * double(values[entry]);
    }
    points.push_back(at);
    ASSERT_LT((at - as_vec3(expected[v].position)).norm(), 1e-6);
    ASSERT_NEAR(value, expected[v].value, 1e-5);
  }
  for (std::size_t v = 0; v < expected.size(); ++v) {
    Vec3 normal = Vec3::Zero();
    for (const std::uint32_t face : motion->faces_at[v]) {
      const auto& [a, b, c, d] = motion->faces[face];
      normal += (points[c] - points[a]).cross(points[d] - points[b]);
    }
    ASSERT_LT((normal.normalized() - as_vec3(expected[v].normal)).norm(), 1e-5);
  }
}

}  // namespace mss::testing
