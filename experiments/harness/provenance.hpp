#pragma once

#include <array>
#include <string>

#include "experiments/harness/json.hpp"

namespace mss {

/// Where a result comes from: program and commit, compiler and flags, versions of the libraries, processor,
/// cores, operating system, sweep kernels, OpenMP settings, and the present UTC date and load average.
Json provenance();

/// "1.0.0 (commit 72ce471, modified)".
std::string program_version();

/// What of a build decides the bits of its results, but for the law of springs: version, commit, compiler and
/// flags.
std::string build_description();
/// Of the law of springs that the program is built with.
std::string spring_law_name();

/// The line at the foot of a chart, from the provenance() of the run: processor, cores, compiler, commit,
/// date, and how busy others kept the cores: their share of them during the run or, where that is not known,
/// the load average at its start.
std::string provenance_line(const Json& provenance);

/// Mean number of processes running or ready to run during the last 1, 5 and 15 minutes.
std::array<double, 3> load_average();

}  // namespace mss
