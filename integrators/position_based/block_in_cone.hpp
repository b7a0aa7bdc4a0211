#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/environment/plane_bounds.hpp"

namespace mss {

/// The quadratic model of a step's objective in one particle's coordinates, about its displacement u in the
/// step: f, minus the gradient, and the Hessian H; unit rows and f = 0 along prescribed axes.
struct VertexModel {
  Eigen::Matrix3d hessian;
  Vec3 force;
};

/// How far the particle moves to the model's minimum under contact: with x = x_n + u + d in front of all
/// planes, held there by forces H d - f that lie in Coulomb's cones. A particle that slides, and would turn
/// round under the friction of the pressure found, sticks. `pressures`: by plane, 0 where there is none;
/// resized and overwritten. `free`: 1 along axes that nothing prescribes.
/// `gaps`: that planes ask for, 0 or less [m].
Vec3 move_in_cone(const std::vector<Plane>& planes, const std::vector<double>& gaps, const Vec3& free,
                  const Vec3& before, const Vec3& u, const VertexModel& model,
                  std::vector<double>& pressures);

}  // namespace mss
