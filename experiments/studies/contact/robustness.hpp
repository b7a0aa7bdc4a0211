#pragma once

#include <vector>

#include "experiments/harness/experiment.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/studies/contact/capstan.hpp"
#include "experiments/studies/contact/drop.hpp"
#include "experiments/studies/contact/pile.hpp"
#include "experiments/studies/contact/random_scenes.hpp"
#include "experiments/studies/contact/self_contact.hpp"

namespace mss::studies::contact {

/// What `mss validate contact` runs of bodies that touch each other or themselves to see whether they hold.
struct RobustnessConfig {
  PileConfig piles;
  std::vector<CapstanRun> ropes;
  SelfContactConfig self;
  DropConfig drops;
  RandomScenesConfig random;
};
RobustnessConfig robustness_config(const ExperimentOptions& options);
Json configuration(const RobustnessConfig& config);

struct RobustnessTables {
  Table pile = empty_pile(), incline = empty_incline(), capstan = empty_capstan(),
        self = empty_self_contact(), drop = empty_drop(), random = empty_random();
};
std::vector<Case> robustness_cases(const RobustnessConfig& config);
/// False if the result of a case is not of these.
bool add_robustness_result(const Json& result, RobustnessTables& tables);
/// Under the names of their files.
std::vector<NamedTable> robustness_files(RobustnessTables tables);
void add_robustness_charts(const std::vector<NamedTable>& tables, Drawings& drawings);
std::string robustness_summary(const RobustnessTables& tables);

}  // namespace mss::studies::contact
