#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

namespace mss::python {

/// A Python value (bool, number, text, path, sequence, array or dict of such) as TOML writes it. Throws
/// InputError for others; `key` says whose value it is.
std::string toml_value(const pybind11::handle& value, const std::string& key);

/// A scene as a TOML file, from a dict of its tables.
std::string toml_text(const pybind11::dict& scene);

/// The items of a dict as `--set` has them: "table.key=value".
std::vector<std::string> toml_overrides(const pybind11::dict& settings);

}  // namespace mss::python
