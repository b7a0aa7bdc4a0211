#pragma once

#include <vector>

#include "core/scene/scene.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/scene_run.hpp"

namespace mss {

/// Time that sleep saved, and the error it caused, compared with the same scene without sleep.
struct SleepReport {
  double share = 0;                  ///< of all planes of particles that slept, mean over time
  double seconds_asleep = no_value;  ///< of a step while all sleep; median
  double seconds_awake = no_value;   ///< of a step of the reference; median
  double largest_deviation = 0;      ///< largest distance of a particle in both runs, of any row [m]
  double apart_at_end = 0;
};

/// One interval between rows of the sleeping run.
struct Interval {
  bool asleep = false;  ///< all particles, throughout
  long steps = 0;
  double seconds = 0;

  void remember(Record& record) { record.keep(asleep, steps, seconds); }
};

/// The same scene without sleep, run beside the one with it, row by row.
template <class Real>
class NonSleepingReference {
 public:
  NonSleepingReference(Scene scene, const Body& body);

  /// Advances it to the same time and compares.
  void advance_and_compare(const SceneRun<Real>& sleeping, double t_end, const Interval& interval);

  SleepReport report() const;
  void remember(Record& record) {
    record.keep(run_, report_.largest_deviation, report_.apart_at_end, shares_, intervals_, asleep_, awake_);
  }

 private:
  SceneRun<Real> run_;
  SleepReport report_;
  double shares_ = 0;  ///< summed over intervals
  long intervals_ = 0;
  std::vector<double> asleep_, awake_;  ///< seconds per step
};

}  // namespace mss
