#pragma once

#include "core/environment/environment.hpp"

namespace mss {

/// What acts on a cube of 1 m, its lower corner the origin, under the tractions of a uniform stress [Pa];
/// only its rigid motions are fixed.
inline Environment uniform_stress(const Eigen::Matrix3d& stress) {
  Environment e{.holds = {{.box = {Vec3::Zero(), Vec3::Zero()}},
                          {.box = {Vec3::UnitX(), Vec3::UnitX()}, .axes = {false, true, true}},
                          {.box = {Vec3::UnitY(), Vec3::UnitY()}, .axes = {false, false, true}}}};
  for (int axis = 0; axis < 3; ++axis)
    for (const bool far : {false, true}) {
      Box face{Vec3::Zero(), Vec3::Ones()};
      face.lower[axis] = face.upper[axis] = far ? 1 : 0;
      e.loads.push_back({.box = face, .force = (far ? 1 : -1) * stress.col(axis)});
    }
  return e;
}

}  // namespace mss
