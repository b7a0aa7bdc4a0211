#pragma once

#include "experiments/harness/report.hpp"

namespace mss::cli {

/// Prints the outcome of an experiment and returns the exit status.
int conclude(const Report& report);

}  // namespace mss::cli
