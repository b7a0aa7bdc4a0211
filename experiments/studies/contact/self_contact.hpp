#pragma once

#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"

namespace mss::studies::contact {

/// A body that is brought to lie on itself: a ring pressed flat and a strip folded over, which are scenes
/// that come with the program, and an arch whose feet are pushed together; with and without contact.
struct SelfContactRun {
  std::string scene;  ///< of self_contact_scenes()
  std::string integrator;
  bool touches = true;

  std::string name() const;
};
const std::vector<std::string>& self_contact_scenes();

struct SelfContactConfig {
  std::vector<SelfContactRun> runs;
};
SelfContactConfig self_contact_config(const ExperimentOptions& options);

Table empty_self_contact();
/// The run as a row: the most pairs of triangles that go through each other by more than a tenth of a cell at
/// any of twenty moments. Its status is `ok`; `crosses`; how the method ended; or `refused`.
void add_self_contact_run(const SelfContactRun& run, Table& rows);

}  // namespace mss::studies::contact
