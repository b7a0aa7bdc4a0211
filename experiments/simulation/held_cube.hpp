#pragma once

#include <vector>

#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/moving_body.hpp"

namespace mss {

/// A cube of springs, 1 m and 1000 kg/m^3, held at the face x = 0 and straight at the start.
struct HeldCube : MovingBody {
  /// `ratio` of damping to critical, of every spring. Without loads it is under gravity.
  HeldCube(const ElasticConstants& material, int cells, double ratio, int threads,
           const std::vector<Load>& loads = {})
      : MovingBody(unit_cube(material, 1000, cells, ratio),
                   {.gravity = loads.empty() ? Vec3(0, 0, -9.81) : Vec3(0, 0, 0),
                    .holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}},
                    .loads = loads},
                   threads) {}
};

}  // namespace mss
