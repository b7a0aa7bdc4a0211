#pragma once

#include <memory>
#include <string>

#include "core/body/body.hpp"

namespace mss::reference {

/// A body's particles and springs as a soft body of the Bullet physics engine, where this program was built
/// with it: its own position-based solver, links of full stiffness, one iteration a step, as it comes. It
/// knows no Young's modulus and no volume force; it is here for the time that a step takes.
class BulletCube {
 public:
  /// The version built with; empty: none.
  static std::string version();
  /// "single" or "double", what it was built to compute with.
  static std::string precision();

  /// Throws std::logic_error where there is none.
  BulletCube(const Body& body, const Vec3& gravity);
  ~BulletCube();
  BulletCube(const BulletCube&) = delete;
  BulletCube& operator=(const BulletCube&) = delete;

  /// One step of the soft body alone: prediction, with its bounding volumes, constraints, velocities.
  void step(double dt);
  /// Of a particle by its id [m].
  Vec3 position(std::size_t particle) const;

 private:
  struct Engine;
  std::shared_ptr<Engine> engine_;  // shared, as it is defined where Bullet is
};

}  // namespace mss::reference
