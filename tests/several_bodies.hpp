#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "core/bodies/bodies_system.hpp"
#include "core/springs/spring_system.hpp"

namespace mss::testing {

/// A block of rubber: cells of 5 cm, 1 MPa, 1000 kg/m^3.
inline BodyConfig rubber_block(const VoxelGrid& voxels, const Vec3& origin, double cell_size = 0.05) {
  BodyConfig config{.voxels = voxels, .cell_size = cell_size, .origin = origin};
  config.fill({.young = 1e6, .poisson = 0.3}, 0.5);
  return config;
}

/// Bodies of springs in one system, which lives as long as this.
template <class Real = double>
class SeveralBodies {
 public:
  SeveralBodies(const std::vector<BodyConfig>& configs, const Environment& environment, int threads = 1) {
    typename BodiesSystem<Real>::Bodies systems;
    for (const BodyConfig& config : configs)
      systems.push_back(std::make_unique<SpringSystem<Real>>(
          bodies_.emplace_back(config), environment_of_body(environment, nullptr), Execution{.threads = 1}));
    system_ = std::make_unique<BodiesSystem<Real>>(std::move(systems), environment,
                                                   typename BodiesSystem<Real>::Surfaces{}, threads);
  }
  BodiesSystem<Real>& system() { return *system_; }
  /// Adds to positions or velocities of a body.
  static void add(const Level& level, const Vec3& by, Field<Real>& field) {
    for (const std::ptrdiff_t site : level.body.sites())
      field.set(level.first + site, field.at(level.first + site) + by);
  }

 private:
  std::deque<Body> bodies_;
  std::unique_ptr<BodiesSystem<Real>> system_;
};

}  // namespace mss::testing
