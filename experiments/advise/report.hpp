#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/advise/advise.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::advise {

/// The tables of an advice: `advise`, a row per trial, and `advise_request`, one row: what was requested, the
/// row of `advise` that is best, counted from 1 (0: none), and whether it is within the budget [s/s] (0:
/// there is none); and `advise_elements`, what it differs from finite elements by, empty where there is
/// nothing to compare.
std::vector<NamedTable> advice_tables(const SceneFamily& family, const AdviseRequest& request,
                                      const Advice& advice);

/// Writes the tables, the chart, meta.json and, where something is advised, its scene as NAME_advised.toml to
/// a directory. Files of these names that an earlier request left are replaced or removed. `origin`: the
/// provenance.
void write_advice(const SceneFamily& family, const AdviseRequest& request, const Advice& advice,
                  const Json& origin, const std::filesystem::path& directory);

/// What is advised, in lines for stdout.
std::string summary(const SceneFamily& family, const AdviseRequest& request, const Advice& advice);

}  // namespace mss::advise
