#pragma once

#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"

namespace mss::studies::frames {

/// A cube of 1 m and 1000 kg/m^3, held at the face x = 0, released straight under gravity.
struct FrameScene {
  std::string name;
  int cells = 7;  ///< per edge
  double young = 1e6;
  double poisson = 0.3;
  double damping_ratio = 0.01;

  std::string description() const;
};

/// A method and its solvers, to be tried with several numbers of iterations and of steps a frame.
struct Family {
  std::string integrator;
  std::string nonlinear = {};  ///< empty: the default, to its tolerance
  std::string linear = {};     ///< empty: the default
  std::vector<int> iterations{0};
  std::vector<int> steps{1};    ///< a frame
  double chebyshev_radius = 0;  ///< of vbd

  std::string name() const;
};

/// Settings of the motions of `mss frames`.
struct FramesConfig {
  std::vector<FrameScene> scenes;
  std::vector<Family> families;
  int frames = 20;
  int repetitions = 3;
  double seconds_per_row = 0.5;  ///< after which a row is not repeated
  int threads = 1;
};
FramesConfig frames_config(const ExperimentOptions& options);

struct FrameTables {
  Table rows;
  Table fits;  ///< of methods without a modulus, how stiff they were made
  Status status = Status::ok;
};

/// A row per scene, family, number of iterations and of steps, and per explicit method at its safe step: wall
/// time of the whole motion, set-up included, and over that of the fastest explicit method in the same round;
/// `error`, the distance from the true motion, and `distance`, that from backward Euler's motion with a step
/// a frame, solved to convergence. Both are root mean squares over frames and particles, over that of the
/// true displacements.
FrameTables measure_frames(const FramesConfig& config, Progress& progress);

/// For every scene and several errors: the cheapest row that meets it, beside the fastest explicit method.
Table frames_summary(const Table& rows);

/// For every scene and family with iterations: how many bring it within 10 and 1 percent of converged
/// backward Euler at a step a frame.
Table frames_iterations(const Table& rows);

/// Settings of the equilibria of `mss frames`.
struct RestConfig {
  std::vector<FrameScene> scenes;
  std::vector<Family> families;
  std::vector<double> tolerances;  ///< of methods that stop at one
  int repetitions = 5;
  double seconds_per_row = 1;
  int threads = 1;
};
RestConfig rest_config(const ExperimentOptions& options);

/// A row per scene, family and tolerance: wall time from the straight cube to where it hangs at rest, and the
/// distance from there, over the displacement, root mean squares. Stops early if stopped.
Table measure_rest(const RestConfig& config, Progress& progress);

/// All scenes, a motion, iterations, a rest, and total errors.
Drawings draw_frames(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::frames
