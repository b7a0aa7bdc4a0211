#pragma once

#include <array>
#include <string>

#include "experiments/harness/json.hpp"

namespace mss {

/// Where a result comes from: program and commit, compiler and flags, versions of what it is built on,
/// processor, cores, operating system, sweep kernels, OpenMP settings, and what the machine is doing at this
/// moment (UTC date, load average).
Json provenance();

/// "0.1.0 (commit 72ce471, modified)".
std::string program_version();

/// One line of provenance() for a chart's foot: processor, cores, compiler, commit, date.
std::string provenance_line(const Json& provenance);

/// Processes that wanted to run during the last 1, 5 and 15 minutes.
std::array<double, 3> load_average();

}  // namespace mss
