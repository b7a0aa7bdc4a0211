#pragma once

#include <cmath>
#include <memory>

#include "core/body_system.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/studies/frames/frames.hpp"

namespace mss::studies::frames {

/// The body of a scene, its system, and distances between its positions.
struct Cube {
  Cube(const FrameScene& scene, int threads)
      : body(unit_cube({.young = scene.young, .poisson = scene.poisson}, 1000, scene.cells,
                       scene.damping_ratio)),
        owned(make_system<double>(spring_model, body,
                                  {.gravity = Vec3(0, 0, -9.81), .holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}}},
                                  threads)),
        system(*owned),
        start(system.undeformed_state()) {}

  /// Sum over particles of the squared distances [m^2].
  double squared_distance(const Field<double>& a, const Field<double>& b) const {
    double sum = 0;
    for (const std::ptrdiff_t site : body.sites()) sum += (a.at(site) - b.at(site)).squaredNorm();
    return sum;
  }

  Body body;
  std::unique_ptr<BodySystem<double>> owned;
  BodySystem<double>& system;
  State<double> start;
};

}  // namespace mss::studies::frames
