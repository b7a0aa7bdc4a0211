#pragma once

#include <vector>

#include "experiments/harness/experiment.hpp"

namespace mss::advise {

/// Error against cost of the candidates, from the tables of report.hpp alone.
Drawings draw(const std::vector<NamedTable>& tables);

}  // namespace mss::advise
