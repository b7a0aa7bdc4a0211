#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/fit/fit.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::fit {

/// The tables of a fit: `fit`, a row a parameter; `fit_data`, a row a measured number; `fit_correlation`, a
/// row a pair of parameters; `fit_steps`, what was tried.
std::vector<NamedTable> fit_tables(const FitProblem& problem, const FitResult& result);

/// The fitted scene as a scene file that lies in `folder`.
std::string fitted_scene(const FitProblem& problem, const FitResult& result,
                         const std::filesystem::path& folder);

/// Writes the tables, charts, meta.json and the fitted scene, NAME_fitted.toml. `origin`: the provenance.
void write_fit(const FitProblem& problem, const FitResult& result, const Json& origin,
               const std::filesystem::path& directory);

/// How a fit ended, for tables and people.
std::string to_string(Ended ended);

/// What was found, in lines for stdout.
std::string summary(const FitProblem& problem, const FitResult& result);

/// What to know before the values are trusted, a sentence each.
std::vector<std::string> warnings_of(const FitProblem& problem, const FitResult& result);

}  // namespace mss::fit
