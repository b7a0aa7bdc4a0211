#pragma once

#include <memory>

#include "core/body_system.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/model.hpp"

namespace mss {

/// A cube of springs, 1 m and 1000 kg/m^3, held at the face x = 0 and straight at the start: its system,
/// under gravity, and distances between positions.
struct HeldCube {
  /// `ratio` of damping to critical, of every spring.
  HeldCube(const ElasticConstants& material, int cells, double ratio, int threads)
      : body(unit_cube(material, 1000, cells, ratio)),
        owned(make_system<double>(spring_model, body,
                                  {.gravity = Vec3(0, 0, -9.81), .holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}}},
                                  threads)),
        system(*owned),
        start(system.undeformed_state()) {}
  /// The system refers to the body.
  HeldCube(const HeldCube&) = delete;
  HeldCube& operator=(const HeldCube&) = delete;

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

}  // namespace mss
