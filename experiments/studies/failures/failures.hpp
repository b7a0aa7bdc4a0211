#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/springs/body_system.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/journal.hpp"
#include "experiments/simulation/outcome.hpp"

namespace mss::studies::failures {

/// A cube and its initial state, to which a stress is added before it is released.
struct StressCase {
  BodyConfig body;
  Environment environment = {};
  /// Initial place of the particle whose rest position is `rest`, both in cells from the lower corner; empty:
  /// the rest position.
  std::function<Vec3(const Vec3& rest)> place = {};
  Vec3 velocity = Vec3::Zero();  ///< [m/s]
  Vec3 spin = Vec3::Zero();      ///< about its middle [rad/s]
  double step_ratio = 1;         ///< every other step is shorter by this factor
};

/// A kind of stress and its severities, from mild to severe.
struct FailureScene {
  std::string name;   ///< in tables
  std::string label;  ///< on charts, with the severity's quantity and unit
  std::vector<double> severities;
  void (*set)(StressCase& stress_case, double severity);
};
const std::vector<FailureScene>& failure_scenes();

/// The cube of 3 x 3 x 3 cells, 1 m, at rest: what all scenes are made from.
StressCase unloaded_cube();
inline constexpr int failure_cells = 3;

/// A body with or without a guard against folding, and of which of the two it takes the step.
struct Variant {
  bool guarded = false;
  bool guarded_step = false;
};
/// In the order of tables and bars: without, without at the guarded body's step, with.
inline constexpr std::array<Variant, 3> variants{{{false, false}, {false, true}, {true, true}}};

struct FailureConfig {
  std::vector<FailureScene> scenes;
  std::vector<std::string> integrators;
  int random_scenes = 1000;  ///< at the step dt = "safe" selects
  std::uint64_t seed = 1;    ///< of the first
};
FailureConfig failure_config(const ExperimentOptions& options);

/// Of a cell: what is less far behind a plane is there by rounding.
inline constexpr double behind_a_plane = 1e-6;

/// What stands in the column `status`: the outcome, but `behind_plane` where it would be `stable` and a
/// particle was behind a plane, or the centre of mass.
struct FailureRun {
  Outcome outcome = Outcome::stable;
  bool behind_plane = false;
  double dt = 0;           ///< [s]
  double seconds = 0;      ///< simulated [s]
  std::int64_t steps = 0;  ///< taken
  /// 1 where planes gave the body impulses, 0 where there are planes and they did not.
  double touched = no_value;
  double depth = 0;  ///< of the deepest particle behind a plane, of all samples [m]
  /// Of the lowest centre of mass of all samples above a plane [m]; infinite without planes.
  double height = std::numeric_limits<double>::infinity();
  RunExtremes extremes{};

  std::string status() const { return behind_plane ? "behind_plane" : std::string(to_string(outcome)); }
};

/// Statuses and how legends show them, in the order of bars.
struct FailureStatus {
  std::string name, label;
};
const std::vector<FailureStatus>& failure_statuses();

/// Runs a case for twenty times as long as sound takes through the cube and back. Methods with a guaranteed
/// step take the safe one (guarded, that of guarded_spectral_bound()); explicit Euler, which has none, takes
/// 0.9 of the one predicted about rest, or where that is none the safe one of semi_implicit_euler; the others
/// take ten times the safe step of semi_implicit_euler, or intervals of that length if they choose their own
/// steps. Throws std::logic_error if it has planes and none has acted at a stable end: then something else
/// ran than was meant.
FailureRun try_scene(const StressCase& stress_case, const IntegratorInfo& method, Variant variant = {});

/// Strains up to which dt = "safe" is meant to be stable: it is guaranteed for small motions and keeps a
/// tenth in reserve for what deformation adds.
inline constexpr double safe_strain = 0.05;

/// A random body and initial state within the range that dt = "safe" is meant for, and a method.
struct RandomScene {
  BodyConfig body;
  Environment environment{};
  std::string integrator{};
  Vec3 stretch = Vec3::Ones();  ///< initial, along each axis
  double random_speed = 0;      ///< of particles, over that of the fastest mode at safe_strain of a cell
  std::uint64_t seed = 0;
};
RandomScene random_scene(std::uint64_t seed);
FailureRun try_scene(const RandomScene& scene);

struct FailureTables {
  Table rows;    ///< per scene, severity, variant and method
  Table random;  ///< per random scene
  Table scenes;  ///< the scenes with their labels
  Status status = Status::ok;
};
FailureTables measure_failures(const FailureConfig& config, int processes, Journal& journal,
                               Progress& progress);
/// The tables as they are written, by the names of their files.
std::vector<NamedTable> failure_files(FailureTables tables);

/// How many methods, without what is a variant of another one, have which outcome: bars of a severity's
/// variants, a panel per scene.
Drawings draw_failures(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::failures
