#pragma once

#include <string>
#include <vector>

#include "experiments/studies/frames/frames.hpp"

namespace mss::studies::frames {

/// A scene in a material, in cells of several sizes and, for reference, in finer ones.
struct TotalProblem {
  std::string scene;   ///< see bench_scenes.hpp
  double young = 1e6;  ///< [Pa]
  double ratio =
      0.01;  ///< of damping to critical of edge springs in the finest of `cells`; its viscosity is kept
  std::vector<int> cells;    ///< as the scene counts them, ascending, each a multiple of the first
  int reference_cells = 16;  ///< a multiple of all of them

  std::string name() const;
};

/// Settings of the total errors of `mss frames`.
struct TotalConfig {
  std::vector<TotalProblem> problems;
  std::vector<Family> families;
  int frames = 0;  ///< 0: as the scenes have them
  int repetitions = 3;
  double most_seconds = 0.6;  ///< that a run may take
};
TotalConfig total_config(const ExperimentOptions& options);

/// `rows`: per problem, number of cells, explicit method at its safe step or family, its steps and
/// iterations: wall time, and its errors at the places of the particles of the coarsest cells that all cells
/// have, root mean squares over frames and places, over the displacement of the reference: `error_time` from
/// the true motion in the same cells, `error_total` from that in the reference's. `cells`: per problem and
/// number of cells `error_space`, of the true motion in these cells from that in the reference's, and how
/// well both are known in time.
struct TotalTables {
  Table rows;
  Table cells;
  Status status = Status::ok;
};
TotalTables measure_totals(const TotalConfig& config, Progress& progress);

std::vector<NamedTable> total_files(const TotalTables& tables);

/// Per problem: total error against wall time, the best of all cells, with the error of time alone of the
/// same runs.
std::vector<NamedChart> total_charts(const Table& rows, const Table& cells);

/// Of rows of one method those that no other beats in both time and, by 2 percent, total error, ascending in
/// time.
std::vector<std::size_t> best_totals(const Table& rows);

}  // namespace mss::studies::frames
