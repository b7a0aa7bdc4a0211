#pragma once

#include <string>
#include <vector>

#include "core/body/body.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::contact {

inline constexpr double gravity = 9.81;  ///< [m/s^2]

/// What a body does on planes: it rests under its weight, and under five times as much more; sticks to a
/// slope and slides down another; falls; lies in a groove of two planes.
enum class FloorTask { rest, loaded, stick, slide, drop, groove };

/// A task and its planes, on which a body begins at rest, undeformed.
struct FloorScene {
  FloorTask task{};
  std::string name;      ///< in tables
  std::string label;     ///< on charts
  std::string quantity;  ///< what the error is of
  std::string unit;      ///< of the error; empty: relative
  double degrees = 0;    ///< of the slope; of a groove, of either side
  double friction = 0;
  double burden = 0;   ///< mass on the body's top, over its own
  double height = 0;   ///< it falls from, along the normal of every plane [m]
  double seconds = 0;  ///< simulated time at 60 steps a second
};
const std::vector<FloorScene>& floor_scenes();

/// A body of every kind: a cube of four cells an edge, the same with a ragged surface, a torus given as a
/// mesh; all of cells of 0.05 m, with the corner of their box in the origin.
const std::vector<std::string>& floor_shapes();
/// Throws std::logic_error for another name.
BodyConfig floor_body(const std::string& shape, double young);

/// A step as tables name it, and its length [s]; 0: the safe one, of methods without a limit that of
/// semi-implicit Euler.
struct FloorStep {
  std::string name;
  double dt;
};
const std::vector<FloorStep>& floor_steps();

/// A row of the table.
struct FloorRun {
  std::string shape;
  FloorScene scene{};
  std::string integrator;
  double young = 0;  ///< [Pa]
  FloorStep step{};

  std::string name() const;
};

/// What `mss validate contact` computes of a body on the floor.
struct FloorConfig {
  std::vector<std::string> shapes, integrators;
  std::vector<double> youngs;  ///< [Pa]
  std::vector<FloorStep> steps;
};
FloorConfig floor_config(const ExperimentOptions& options);

/// In the table's order. Methods with a limit take the safe step alone, those of no material do not rest, and
/// shapes other than the cube are at 60 steps a second and safe steps of explicit methods alone.
std::vector<FloorRun> floor_runs(const FloorConfig& config);

Table empty_floor();
/// The run as a row. Its status is `ok`; `off`, where the error is above its bound; `gains_energy`, more than
/// 5 percent, or more than a thousandth when it falls; `penetrates`, by more than 1e-12 m; `never_touched`
/// where it does not touch all planes late in the run; `refused` by the method, with its sentence in the
/// column `reason`; how the method ended; or `not_compared`, if there is nothing to compare with.
void add_floor_run(const FloorRun& run, Table& rows);

/// How many runs of each method are ok and how many have another status, a line each.
std::string floor_summary(const Table& rows);

/// Which method does what at 60 steps a second, by scene and stiffness.
MapChart floor_map(const Table& rows);
/// Error of the cube's sag against the step.
Chart floor_steps_chart(const Table& rows);

}  // namespace mss::studies::contact
