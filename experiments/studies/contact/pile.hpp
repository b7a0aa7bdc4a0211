#pragma once

#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"

namespace mss::studies::contact {

/// Blocks that lie on each other: three in a stack, nine in rows of four, three and two.
struct PileRun {
  std::string pile;  ///< of pile_names()
  std::string integrator;
  double young = 0;      ///< [Pa]
  double stiffness = 1;  ///< of contact
  double seconds = 10;

  std::string name() const;
};
const std::vector<std::string>& pile_names();
/// The scene file of a run. Throws std::logic_error for another name.
std::string pile_scene(const PileRun& run);

/// A block on a block that is tilted.
struct InclineRun {
  std::string integrator;
  double tangent = 0;  ///< of the slope's angle; that of friction is incline_friction

  std::string name() const;
};
inline constexpr double incline_friction = 0.5;
std::string incline_scene(const InclineRun& run);

/// What `mss validate contact` computes of blocks on blocks.
struct PileConfig {
  std::vector<PileRun> piles;
  std::vector<InclineRun> inclines;
};
PileConfig pile_config(const ExperimentOptions& options);

Table empty_pile();
/// The run as a row: how far a block's centre moves in the second half of the time, and how deep a vertex is
/// behind a triangle at its end, both over a cell. Its status is `ok`; `drifts`, by more than 1e-4; `sinks`,
/// more than a hundredth; how the method ended; or `refused`, with its sentence in the column `reason`.
void add_pile_run(const PileRun& run, Table& rows);

Table empty_incline();
/// The run as a row: how far the block slid in half a second beside Coulomb's law. Its status is `ok`; `off`,
/// by more than a hundredth of what it slides without friction; how the method ended; or `refused`.
void add_incline_run(const InclineRun& run, Table& rows);

/// Penetration of the stack of three against E, by contact's stiffness.
Chart pile_depth_chart(const Table& rows);

}  // namespace mss::studies::contact
