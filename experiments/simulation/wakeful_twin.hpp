#pragma once

#include <limits>
#include <vector>

#include "core/scene.hpp"
#include "experiments/simulation/scene_run.hpp"

namespace mss {

/// What sleep saved, and the error it added, against the same scene without sleep.
struct SleepReport {
  double share = 0;  ///< of all particles' planes, over time, that slept
  double seconds_asleep = std::numeric_limits<double>::quiet_NaN();  ///< of a step while all sleep; median
  double seconds_awake = std::numeric_limits<double>::quiet_NaN();   ///< of a step of the twin; median
  double most_apart = 0;  ///< largest distance between a particle and its twin, of any row [m]
  double apart_at_end = 0;
};

/// How long part of a run took.
struct Lap {
  bool asleep = false;  ///< all, from beginning to end
  long steps = 0;
  double seconds = 0;
};

/// A scene that never sleeps, run beside one that does, row by row.
template <class Real>
class WakefulTwin {
 public:
  WakefulTwin(Scene scene, const Body& body);

  /// Takes the twin to the same time and compares; `lap` is what that took the one that sleeps.
  void follow(const SceneRun<Real>& sleeper, double t_end, const Lap& lap);

  SleepReport report() const;

 private:
  SceneRun<Real> run_;
  SleepReport report_;
  double shares_ = 0;  ///< summed over laps
  long laps_ = 0;
  std::vector<double> asleep_, awake_;  ///< seconds per step
};

}  // namespace mss
