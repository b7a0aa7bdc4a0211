#pragma once

#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"
#include "experiments/studies/reduce/scenes.hpp"

namespace mss::studies::reduce {

/// A model that reduces bodies, with so many modes.
struct ReducedModel {
  std::string name{};
  int modes = 8;
};

/// A body, the lattices that stand for it and the models that reduce it.
struct Subject {
  Solid solid{};
  std::vector<int> cells{};  ///< along x, ascending; the last are its own
  std::vector<ReducedModel> models{};
  bool all_modes = false;  ///< lattices are matched to its six slowest vibrations too
};

/// Settings of `mss reduce`.
struct ReduceConfig {
  std::vector<Subject> subjects{};
  std::vector<ReduceScene> scenes{};
  int frames = 30;
  int repetitions = 3;
  double sample_seconds = 4e-3;  ///< that a sample of a time takes at least
};
ReduceConfig reduce_config(const ExperimentOptions& options);

/// `rows`: per scene and model, its error and what a frame costs in stepping and in drawing; `gain_matched`
/// and `gain_unmatched`: the cost of the cheapest explicit lattice of no larger error, its moduli matched or
/// not, or of those unmatched, over its own; `warned`: what a run of the model warns of. `scenes`: what each
/// scene did. `matched`: how far vibrations of lattices are off whose moduli were matched.
struct ReduceTables {
  Table rows;
  Table scenes;
  Table matched;
  Status status = Status::ok;
};
ReduceTables measure_reduce(const ReduceConfig& config, Progress& progress);

/// Gains, and error against cost by scene.
Drawings draw_reduce(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::reduce
