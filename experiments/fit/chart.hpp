#pragma once

#include <vector>

#include "experiments/harness/experiment.hpp"

namespace mss::fit {

/// Fit beside data, from the tables of report.hpp alone: `fit`, the residuals of single values, and
/// `fit_series_N`, a chart for each series.
Drawings draw(const std::vector<NamedTable>& tables);

}  // namespace mss::fit
