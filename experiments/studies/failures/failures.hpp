#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/body_system.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/journal.hpp"
#include "experiments/simulation/fate.hpp"

namespace mss::studies::failures {

/// A cube, and what is done to it before it is let go.
struct Hardship {
  BodyConfig body;
  Environment environment = {};
  /// Where a particle is put that rests at `rest`, both in cells from the lower corner; empty: there.
  std::function<Vec3(const Vec3& rest)> place = {};
  Vec3 velocity = Vec3::Zero();  ///< [m/s]
  Vec3 spin = Vec3::Zero();      ///< about its middle [rad/s]
  double jump = 1;               ///< every other step is so much shorter
};

/// A way to bring methods to their limits, ever harder.
struct FailureScene {
  std::string name;   ///< of rows
  std::string label;  ///< with what is counted and its unit
  std::vector<double> severities;
  void (*set)(Hardship& hardship, double severity);
};
const std::vector<FailureScene>& failure_scenes();

/// The cube of 3 x 3 x 3 cells, 1 m, that all scenes begin with.
Hardship at_ease();
inline constexpr int failure_cells = 3;

struct FailureConfig {
  std::vector<FailureScene> scenes;
  std::vector<std::string> integrators;
  int random_scenes = 2100;  ///< at the step dt = "safe" stands for
  std::uint64_t seed = 1;    ///< of the first
};
FailureConfig failure_config(const ExperimentOptions& options);

struct FailureRun {
  Fate fate = Fate::holds;
  double dt = 0;           ///< [s]
  double seconds = 0;      ///< simulated [s]
  std::int64_t steps = 0;  ///< taken
  Watch watch{};
};

/// Twenty slow periods of a cube. Methods with a largest step take their safe one (guarded, that of
/// crushed_spectral_bound()), explicit Euler, which has no safe one, what is predicted about rest, guarded or
/// not; the others take ten times that of symplectic Euler, or are asked for such intervals.
FailureRun try_scene(const Hardship& hardship, const IntegratorInfo& method);

/// Strains up to which dt = "safe" is meant to hold: it is sure of small motions and leaves a tenth for what
/// deformation adds.
inline constexpr double safe_strain = 0.05;

/// A body, a method and what is done to both, within the range that dt = "safe" is meant for.
struct RandomScene {
  BodyConfig body;
  Environment environment{};
  std::string integrator{};
  Vec3 stretch = Vec3::Ones();  ///< along each axis before it is let go
  double rattle = 0;  ///< speed of random motions, over that of the fastest mode at safe_strain of a cell
  std::uint64_t seed = 0;
};
RandomScene random_scene(std::uint64_t seed);
FailureRun try_scene(const RandomScene& scene);

struct FailureTables {
  Table rows;    ///< per scene, severity, guard and method
  Table random;  ///< per random scene
  Status status = Status::ok;
};
FailureTables measure_failures(const FailureConfig& config, int processes, Journal& journal,
                               Progress& progress);

}  // namespace mss::studies::failures
