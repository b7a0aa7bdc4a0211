#pragma once

#include <string>

#include "core/measures/measures.hpp"
#include "experiments/simulation/moving_body.hpp"

namespace mss {

/// The extremes of a motion, at its start and at the ends of its frames.
struct MotionExtremes {
  double first_energy = 0;  ///< kinetic and stored, at the start [J]
  double energy = 0;        ///< largest [J]
  double work = 0;          ///< most that gravity and loads have done until any frame [J]
  double displacement = 0;  ///< largest root mean square over particles, from the start [m]
  double depth = 0;         ///< of the deepest particle behind a plane [m]
  double min_jacobian = 1;  ///< of all frames
};

/// Gathers the extremes of a motion.
class MotionWatch {
 public:
  /// The body must outlive it. `velocity_lag` [s]: see outcome.hpp.
  explicit MotionWatch(const MovingBody& body, double velocity_lag = 0);
  void add(const State<double>& state);
  const MotionExtremes& extremes() const { return extremes_; }

 private:
  const MovingBody& body_;
  double velocity_lag_;
  double first_potential_ = 0;
  MotionExtremes extremes_;
};

/// A bounded motion has at most so many times the energy that its scene supplies, and goes at most so many
/// times as far as the true one.
inline constexpr double bounded_factor = 1.5;
/// It is at most so many cells behind a plane.
inline constexpr double bounded_depth = 0.1;

/// What a scene supplies: the energy at its start, and what gravity and loads do in the true motion [J].
double supplied_energy(const MotionExtremes& truth);

/// Why a motion is no answer to a scene however much error is allowed: its "energy", its "displacement", that
/// it is "behind a plane", or "folded" where the true one is not. Empty if it stays within bounds: what
/// "stable" means.
std::string out_of_bounds(const MotionExtremes& run, const MotionExtremes& truth, double cell_size);

}  // namespace mss
