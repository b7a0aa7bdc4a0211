#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/measures/measures.hpp"
#include "experiments/harness/table.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// How the run of a method on a body ends.
enum class Outcome {
  stable,
  loses_energy,    ///< more than the body's damping dissipates
  gains_energy,    ///< at some time more than 5 percent, which nothing supplies, but without growing on
  folds,           ///< a corner of a cell is inverted
  blows_up,        ///< energy grows on, or is ten times the initial one, or numbers are not finite
  stalls,          ///< a solver finds no solution
  too_many_steps,  ///< for one interval, of methods that choose their own
  refused          ///< the method has no step for such a body
};

/// As tables write it, for example "blows_up".
std::string_view to_string(Outcome outcome);

/// The outcome that a table writes so. Throws InputError for any other text.
Outcome read_outcome(std::string_view text);

/// As legends show them, in the enumeration's order.
std::vector<std::string> outcome_labels();

/// The outcome of a run whose last advance() returned this status.
Outcome outcome_of(Status status);

/// What was sampled of a run.
struct RunExtremes {
  double initial_energy = 0;         ///< mechanical [J]
  double max_energy = 0;             ///< mechanical [J]
  double min_jacobian = no_value;    ///< of all samples
  double final_jacobian = no_value;  ///< least one of the last sample
};

/// How long before the time of the positions the velocities that a method returns are those of, to second
/// order [s]: half a step for symplectic methods of first order, which are leapfrog in other variables; taken
/// together their positions and velocities have an energy that oscillates, even where the motion is exact.
double velocity_lag(const IntegratorInfo& method, double dt);

/// Measures with velocities advanced by so much [s], to the time of the positions.
Measures measure_in_time(SolidSystem<double>& system, const State<double>& state, double velocity_lag);

/// The run of a body that nothing supplies with energy: resting holds, planes, no loads and no gravity. Its
/// kinetic and stored energy can only fall, and is compared with the initial one.
class SampledRun {
 public:
  /// Energy above the initial one by more than this share is gained; by errors of a method, as nothing
  /// supplies it. Between two windows of a run, energy that has grown so much is growing on.
  static constexpr double tolerated_growth = 0.05;

  /// `velocity_lag` [s]: see velocity_lag().
  SampledRun(SolidSystem<double>& system, State<double>& state, double velocity_lag = 0);

  /// Advances the state through a window of so many samples: `advance` takes it to the sample of that number,
  /// 1 the first; `sample` receives the measures there. Ends early with the outcome of an advance that fails,
  /// and as blows_up once the energy exceeds ten times the initial one. Otherwise gains_energy or stable, of
  /// all windows so far: the caller decides whether the body has folded or lost energy.
  Outcome run(long samples, const std::function<Status(long)>& advance,
              const std::function<void(const Measures&)>& sample = {});

  const RunExtremes& extremes() const { return extremes_; }
  /// Mean energy of the last window's samples [J].
  double mean_energy() const { return mean_energy_; }

 private:
  SolidSystem<double>& system_;
  State<double>& state_;
  double velocity_lag_;
  RunExtremes extremes_;
  double mean_energy_ = 0;
};

}  // namespace mss
