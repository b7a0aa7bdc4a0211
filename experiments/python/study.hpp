#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace mss::python {

/// The tables of a study as a dict of dicts of arrays: {table: {column: array}}. Options are those of its
/// command, by name. Throws InputError for options that it does not take, and KeyboardInterrupt.
pybind11::dict run_study(const std::string& name, const pybind11::dict& options);

}  // namespace mss::python
