#pragma once

#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"

namespace mss::studies::contact {

/// A rope half around a fixed cylinder: one end carries a load, the other is pulled until the rope slides,
/// then let back.
struct CapstanRun {
  std::string integrator;
  int links = 64;
  double friction = 0.3;

  std::string name() const;
};
std::vector<CapstanRun> capstan_config(const ExperimentOptions& options);
/// The scene file of a run.
std::string capstan_scene(const CapstanRun& run);

Table empty_capstan();
/// Two rows, of pulling and letting back: the mean force on the end over the load while the rope slides,
/// beside Euler and Eytelwein's exp(+-mu pi). The status is `ok`; `off`, by more than 5 percent; how the
/// method ended; or `refused`.
void add_capstan_run(const CapstanRun& run, Table& rows);

}  // namespace mss::studies::contact
