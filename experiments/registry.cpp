// The list of experiments is in CMakeLists.txt beside this file: the line that compiles one also registers
// it.
#include "experiments/experiment.hpp"

namespace mss {

#define MSS_EXPERIMENT(name) ExperimentInfo name();
#include "experiments/experiments.inc"
#undef MSS_EXPERIMENT

const std::vector<ExperimentInfo>& experiments() {
  static const std::vector<ExperimentInfo> all{
#define MSS_EXPERIMENT(name) name(),
#include "experiments/experiments.inc"
#undef MSS_EXPERIMENT
  };
  return all;
}

}  // namespace mss
