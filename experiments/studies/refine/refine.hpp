#pragma once

#include <vector>

#include "experiments/harness/experiment.hpp"
#include "experiments/studies/refine/problems.hpp"

namespace mss::studies::refine {

/// What `mss refine` computes.
struct RefineConfig {
  std::vector<Problem> problems{};
  std::vector<int> cells{};                 ///< per metre, each twice the one before, from 2 up
  std::vector<int> reference_cells{};       ///< three sizes, each twice the one before
  std::vector<double> face_shares{0.5, 1};  ///< t of calibrated springs
  ElasticConstants material{.young = 1e5, .poisson = 0.3};
  int threads = 1;
};
RefineConfig refine_config(const ExperimentOptions& options);

struct EstimateTables {
  Table rows;       ///< a problem in cells of one size: its goal, estimated, corrected, extrapolated
  Table reference;  ///< what these are compared with
  Status status = Status::ok;
};

/// Each problem at each size, with the estimate of its error. References are extrapolated from the three
/// sizes of the lattice given for it, by the order these show; their uncertainty is the difference between
/// those of the first and the last face share.
EstimateTables measure_estimates(const RefineConfig& config, Progress& progress);

/// Raw, corrected and extrapolated errors against cells, a chart per problem and face share.
std::vector<NamedChart> estimate_charts(const Table& rows, const Table& problems);

}  // namespace mss::studies::refine
