#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiments/simulation/moving_body.hpp"
#include "experiments/studies/convergence/convergence.hpp"

// Steps of a frame of bodies of many shapes, and of the scenes that studies share: how far a solver that is
// stopped after so many iterations is from the converged step.

namespace mss::studies::convergence {

/// What moves, from where it begins.
struct StepScene {
  std::string name;
  std::string description;
  double poisson;
  std::function<std::unique_ptr<MovingBody>(int threads)> make;
};

/// A body of 1 m under gravity that is held at a face, in a motion that bends and shears it: 10 MPa, damping
/// ratio 0.5, 1000 kg/m^3.
struct StepBody {
  std::string shape;
  int cells = 20;  ///< per metre
  double poisson = 0.3;

  std::string name() const;
  StepScene scene() const;
};

/// Scenes whose steps are solved by the same solvers, stopped after the same numbers of iterations.
struct StepGroup {
  std::vector<StepScene> scenes;
  std::vector<SolverPair> solvers;
  std::vector<int> iterations;  ///< ascending
};

/// Settings of what `mss convergence` solves beside single hard steps.
struct StepsConfig {
  StepGroup bodies;  ///< by what quasi-Newton methods and conjugate gradients take in place of a matrix
  StepGroup scenes;  ///< those that people have, by all solvers
  int frames = 6;
  int rounds = 3;  ///< of measurements of costs
  int threads = 1;
};
StepsConfig steps_config(const ExperimentOptions& options);
/// The names of the scenes that --scenes takes beside starts.
std::vector<std::string> step_scene_names();

/// A row of `rows` per scene, solver and number of iterations: over the frames, each from the converged step
/// before it, `error`, median and worst, the distance from the converged step, root mean square by mass, over
/// the largest displacement in a frame until then; and the median time of a step by a method that has been
/// set up. Of `bodies` per body and solver: the mean over frames, and the most, of iterations to an error of
/// a percent and of a thousandth, and what one application of what the solver takes for the inverse of a
/// matrix, an iteration and the set-up cost, in steps of semi-implicit Euler of the same body. Of `scenes`:
/// iterations and time to a percent. Of `references`: by how much Newton's method differs from the converged
/// step in the last frame.
struct StepTables {
  Table rows, bodies, scenes, references;
  Status status = Status::ok;
};
StepTables measure_steps(const StepsConfig& config, Progress& progress);

std::vector<NamedTable> step_files(const StepTables& tables);

/// Of two bodies each: error against iterations; and the time to a percent in the scenes that people have.
std::vector<NamedChart> step_charts(const std::vector<NamedTable>& tables);

Json step_configuration(const StepsConfig& config);

}  // namespace mss::studies::convergence
