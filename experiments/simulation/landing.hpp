#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/springs/body_system.hpp"

namespace mss {

/// How a released body ends: at rest in its shape, at rest in its mirror image, at rest with stored energy,
/// not at rest, or with numbers that are not finite.
enum class Recovery { recovered, mirrored, trapped, moving, non_finite };
std::string_view to_string(Recovery outcome);

struct RecoveryTrial {
  Recovery outcome = Recovery::recovered;
  double seconds = 0;       ///< simulated until the end [s]
  double max_stretch = 0;   ///< at the end
  double min_jacobian = 1;  ///< at the end
};

/// A tenth of the stable step of `verlet` about rest, without fold guard [s]: trials begin far from rest, and
/// a guard that acts raises the highest frequency up to threefold.
double trial_step(const BodySystem<double>& system);

/// Advances a state with `verlet` and steps of dt [s] until the body is at rest, trapped (its stored energy
/// remains constant), or the time of 64,000 trial steps is over.
RecoveryTrial settle(BodySystem<double>& system, State<double>& state, double dt);

/// What a cube lands on: a corner, an edge or a face.
struct Landing {
  std::string name;
  Vec3 up;  ///< normal of the ground, of length 1
};
const std::vector<Landing>& landings();

/// Lands a body of a model (model.hpp) along the normal of the ground, a plane through the origin, at a speed
/// [m/s], and lets it bounce and come to rest in the air; dt [s], 0: trial_step(). Recovered if no cell is
/// inverted then, however fast it rotates. The body's origin is replaced.
RecoveryTrial try_landing(const std::string& model, BodyConfig body, const Plane& ground, double speed,
                          double dt = 0);

}  // namespace mss
