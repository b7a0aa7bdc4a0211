#include "experiments/python/toml_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.hpp"

namespace mss::python {

namespace py = pybind11;

namespace {

std::string number(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

/// A TOML string is written as one of JSON.
std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

std::string inline_table(const py::dict& table, const std::string& key) {
  std::vector<std::string> entries;
  for (const auto& [name, value] : table) {
    const auto inner = py::str(name).cast<std::string>();
    entries.push_back(
        fmt::format("{} = {}", quoted(inner), toml_value(value, fmt::format("{}.{}", key, inner))));
  }
  return fmt::format("{{{}}}", fmt::join(entries, ", "));
}

std::string array(const py::sequence& values, const std::string& key) {
  std::vector<std::string> entries;
  for (std::size_t i = 0; i < values.size(); ++i)
    entries.push_back(toml_value(py::object(values[i]), fmt::format("{}.{}", key, i)));
  return fmt::format("[{}]", fmt::join(entries, ", "));
}

}  // namespace

std::string toml_value(const py::handle& given, const std::string& key) {
  // Arrays and numbers of NumPy, as lists and numbers.
  const py::object value =
      py::hasattr(given, "tolist") ? given.attr("tolist")() : py::reinterpret_borrow<py::object>(given);
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::int_>(value)) return py::str(value).cast<std::string>();
  if (py::isinstance<py::float_>(value)) return number(value.cast<double>());
  if (py::isinstance<py::str>(value)) return quoted(value.cast<std::string>());
  if (py::hasattr(value, "__fspath__")) return quoted(value.attr("__fspath__")().cast<std::string>());
  if (py::isinstance<py::dict>(value)) return inline_table(value.cast<py::dict>(), key);
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value))
    return array(value.cast<py::sequence>(), key);
  throw InputError(fmt::format("{} = {} is a {}; give a bool, a number, a text, a list or a dict", key,
                               py::repr(value).cast<std::string>(),
                               py::str(py::type::of(value).attr("__name__")).cast<std::string>()));
}

std::string toml_text(const py::dict& scene) {
  std::string text;
  for (const auto& [name, value] : scene) {
    const auto key = py::str(name).cast<std::string>();
    text += fmt::format("{} = {}\n", quoted(key), toml_value(value, key));
  }
  return text;
}

std::vector<std::string> toml_overrides(const py::dict& settings) {
  std::vector<std::string> overrides;
  for (const auto& [name, value] : settings) {
    const auto key = py::str(name).cast<std::string>();
    overrides.push_back(fmt::format("{}={}", key, toml_value(value, key)));
  }
  return overrides;
}

}  // namespace mss::python
