#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "core/scene/scene.hpp"
#include "experiments/fit/fit.hpp"

namespace mss::python {

/// The tables of a study as a dict of dicts of arrays: {table: {column: array}}. Options are those of its
/// command, by name. Throws InputError for options that it does not take, and KeyboardInterrupt.
pybind11::dict run_study(const std::string& name, const pybind11::dict& options);

/// Simulates a scene to its end. The rows of series.csv and particles.csv as dicts of arrays, and what to
/// know of them. Throws as check_solve(), SimulationFailed, and KeyboardInterrupt.
pybind11::dict run_scene(const Scene& scene);

/// Solves a fit that check_problem() has passed. Its tables as dicts of arrays, how it ended, and the scene
/// with the values found. Throws as fit::fit() and KeyboardInterrupt.
pybind11::dict fit_scene(const fit::FitProblem& problem);

}  // namespace mss::python
