#pragma once

#include <memory>
#include <string>

#include "core/springs/body_system.hpp"

namespace mss::studies::stiffness {

/// A slightly damped cube of 1 m, its bottom held, bent by half a radian and stretched by a tenth: where a
/// step begins that linear solvers find hard.
struct BentCube {
  /// `noise`: the largest displacement in addition, over the cell size.
  BentCube(int n, const ElasticConstants& material, double noise);

  /// A new system of the cube, on one thread.
  std::unique_ptr<BodySystem<double>> system(const std::string& model) const;

  Body body;
  State<double> state;  ///< at rest in this shape, at t = 0
};

}  // namespace mss::studies::stiffness
