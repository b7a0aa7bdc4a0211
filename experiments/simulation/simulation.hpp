#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/bodies/bodies_measures.hpp"
#include "core/measures/measures.hpp"
#include "core/scene/scene.hpp"
#include "core/springs/body_system.hpp"
#include "experiments/harness/progress.hpp"
#include "experiments/simulation/energy_watch.hpp"
#include "experiments/simulation/non_sleeping_reference.hpp"
#include "experiments/simulation/plane_watch.hpp"
#include "experiments/simulation/reduced_watch.hpp"
#include "experiments/simulation/restart.hpp"
#include "experiments/simulation/scene_run.hpp"
#include "experiments/simulation/step_balance.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Position and velocity of one particle, in double precision.
struct ParticleRecord {
  Vec3 rest, x, v;
  double mass = 0;
};

/// What a body has of cells of one size.
struct LevelCount {
  double cell_size = 0;  ///< [m]
  std::size_t cells = 0;
  std::size_t particles = 0;  ///< that move
};

/// A row of series.csv. Forces of planes that give impulses are means over the time since the row before.
struct SeriesRow : Measures {
  Reactions reactions;
  BodiesMeasures bodies;

  void remember(Record& record) {
    Measures::remember(record);
    record.keep(reactions, bodies);
  }
};

/// Result of simulating a scene. A failed run has the rows it finished, and the particles of the last one.
struct SimulationResult {
  Status status = Status::ok;
  Work work;
  /// The step [s], "safe" resolved; of adaptive methods the first. NaN: the method's own choice, or none.
  double dt = std::numeric_limits<double>::quiet_NaN();
  SureSteps sure_steps;
  bool in_local_steps = false;  ///< some cells take longer steps than others
  double simulated_seconds = 0;
  double wall_seconds = 0;  ///< of stepping; measuring, setting up and transfers not counted
  int threads = 1;
  double threads_working = 1;        ///< on average
  std::string kernel;                ///< instruction set of the sweep
  std::string device;                ///< that took the steps; empty: the processor
  double transfer_seconds = 0;       ///< of carrying states there and back, in no other number
  std::vector<LevelCount> levels;    ///< the largest cells first
  std::optional<SleepReport> sleep;  ///< where the scene has particles sleep
  std::optional<EnergyGain> gain;
  std::vector<Penetration> penetrations;
  std::optional<ReducedFit> reduced;     ///< of a reduced body
  std::optional<ContactReport> contact;  ///< between or within bodies, at the end and so far
  std::optional<Imbalance> imbalance;    ///< of some steps, where StepBalance applies
  /// Where restitution acts in steps shorter than this one only, which is near that length [s].
  std::optional<double> rebounding_step;
  std::vector<SeriesRow> series;
  std::vector<ParticleRecord> particles;
  std::vector<Continuation> continued;  ///< the times it went on from, if it did
};

/// Whether and where a series for ParaView is written.
struct VtkChoice {
  long every = 0;  ///< n-th step; of methods that choose their steps, row of series.csv. 0: never
  std::filesystem::path directory;
};

/// A body at rest, but stretched along z by a factor, about z = 0.
template <class Real>
State<Real> stretched_state(const BodySystem<Real>& system, double factor);

/// Ranks that simulate a scene together: each must call simulate() then. All get the same result, but for the
/// particles: a rank gets its own, which follow those of the rank below.
struct SharedRun {
  const Communicator& ranks = Communicator::alone();
  std::function<void(const SeriesRow&)> on_row = [](const SeriesRow&) {};  ///< as soon as one is there
};

/// Simulates a scene from beginning to end, or from where another run ended, and writes the series if that is
/// chosen. Throws as check_solve() in scene_check.hpp, and InputError if a file cannot be written. What a run
/// that went on has counted and timed is that of all its parts. Ranks leave nothing to go on from.
SimulationResult simulate(const Scene& scene, Progress& progress, const VtkChoice& vtk = {},
                          const SharedRun& shared = {}, const RestartChoice& restart = {});

}  // namespace mss
