#include "experiments/python/study.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <map>

#include "core/base/error.hpp"
#include "experiments/fit/report.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/python/simulation.hpp"
#include "experiments/simulation/diagnostics.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/result_files.hpp"

namespace mss::python {

namespace py = pybind11;

namespace {

/// Stops a study where Python has received Ctrl-C. Studies fork workers, which have no interpreter to ask.
class PythonProgress final : public Progress {
 public:
  bool stopped() const override {
    if (getpid() != process_) return false;
    const py::gil_scoped_acquire lock;
    stopped_ = stopped_ || PyErr_CheckSignals() != 0;
    return stopped_;
  }
  /// To be called with the interpreter's lock.
  void rethrow() const {
    if (stopped_) throw py::error_already_set();
  }

 private:
  pid_t process_ = getpid();
  mutable bool stopped_ = false;
};

template <class T>
T cast(const py::handle& value, const std::string& key, std::string_view allowed) {
  try {
    return value.cast<T>();
  } catch (const py::cast_error&) {
    throw InputError(fmt::format("{} = {} is not {}", key, py::repr(value).cast<std::string>(), allowed));
  }
}

int whole(const py::handle& value, const std::string& key) {
  const int number = cast<int>(value, key, "a whole number");
  constexpr int most = 1024;
  if (number < 0 || number > most)
    throw InputError(fmt::format("{} = {}; give a number from 0 to {}", key, number, most));
  return number;
}

std::vector<int> cells(const py::handle& value, int largest) {
  auto numbers = cast<std::vector<int>>(value, "cells", "a list of whole numbers");
  for (const int n : numbers)
    if (n < 1 || n > largest)
      throw InputError(fmt::format("cells has {}; give numbers of cells per edge from 1 to {}", n, largest));
  return numbers;
}

using Setters = std::map<std::string, std::function<void(const py::handle&)>, std::less<>>;

/// What sets the options that a study takes, by their names.
Setters setters(const ExperimentInfo& info, ExperimentOptions& o) {
  Setters all{{"quick", [&](const py::handle& v) { o.quick = cast<bool>(v, "quick", "True or False"); }}};
  const ExperimentAccepts& accepts = info.accepts;
  if (accepts.cells)
    all["cells"] = [&](const py::handle& v) { o.cells = cells(v, info.accepts.largest_cells); };
  if (accepts.integrators != nullptr)
    all["integrators"] = [&](const py::handle& v) {
      o.integrators = cast<std::vector<std::string>>(v, "integrators", "a list of names");
      info.accepts.integrators(o.integrators);  // throws
    };
  if (accepts.scenes != nullptr)
    all["scenes"] = [&](const py::handle& v) {
      o.scenes = cast<std::vector<std::string>>(v, "scenes", "a list of names");
      check_scenes(o.scenes, info.accepts.scenes());
    };
  if (accepts.model)
    all["model"] = [&](const py::handle& v) {
      o.model = cast<std::string>(v, "model", "a name");
      check_model_name(o.model);
    };
  if (accepts.threads) all["threads"] = [&](const py::handle& v) { o.threads = whole(v, "threads"); };
  if (accepts.processes) all["processes"] = [&](const py::handle& v) { o.processes = whole(v, "processes"); };
  if (accepts.seed)
    all["seed"] = [&](const py::handle& v) { o.seed = cast<std::uint64_t>(v, "seed", "a whole number"); };
  if (accepts.peers)
    all["peers"] = [&](const py::handle& v) { o.peers = cast<bool>(v, "peers", "True or False"); };
  if (accepts.settings)
    all["settings"] = [&](const py::handle& v) {
      o.settings = cast<std::vector<std::string>>(v, "settings", "a list of texts, \"table.key=value\"");
    };
  return all;
}

ExperimentOptions options_from(const ExperimentInfo& info, const py::dict& given) {
  ExperimentOptions options;
  const Setters known = setters(info, options);
  for (const auto& [name, value] : given) {
    const auto key = py::str(name).cast<std::string>();
    const auto setter = known.find(key);
    if (setter == known.end()) {
      std::vector<std::string> names;
      for (const auto& [option, set] : known) names.push_back(option);
      throw InputError(
          fmt::format("{} has no option '{}'; it takes {}", info.name, key, fmt::join(names, ", ")));
    }
    setter->second(value);
  }
  return options;
}

/// A column as integers if all its cells are, as doubles if all are numbers, else as texts.
py::object column_of(const Table& table, std::size_t column) {
  std::size_t texts = 0, integers = 0;
  for (const auto& row : table.rows()) {
    texts += std::size_t(std::holds_alternative<std::string>(row[column]));
    integers += std::size_t(std::holds_alternative<std::int64_t>(row[column]));
  }
  const std::string& name = table.columns()[column].name;
  py::list values;
  for (std::size_t r = 0; r < table.size(); ++r)
    if (texts > 0)
      values.append(table.text(r, name));
    else if (integers == table.size())
      values.append(std::get<std::int64_t>(table.rows()[r][column]));
    else
      values.append(table.number(r, name));
  const char* type = texts > 0 ? "str" : integers == table.size() && integers > 0 ? "int64" : "float64";
  return py::module_::import("numpy").attr("array")(values, type);
}

py::dict columns_of(const Table& table) {
  py::dict columns;
  for (std::size_t c = 0; c < table.columns().size(); ++c)
    columns[py::str(table.columns()[c].name)] = column_of(table, c);
  return columns;
}

/// As particles.csv has them.
Table particle_table(const std::vector<ParticleRecord>& particles) {
  Table table(
      {{"id"}, {"rest_x"}, {"rest_y"}, {"rest_z"}, {"x"}, {"y"}, {"z"}, {"vx"}, {"vy"}, {"vz"}, {"mass"}});
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const auto& [rest, x, v, mass] = particles[p];
    table.add({std::int64_t(p), rest[0], rest[1], rest[2], x[0], x[1], x[2], v[0], v[1], v[2], mass});
  }
  return table;
}

}  // namespace

py::dict run_study(const std::string& name, const py::dict& given) {
  const auto by_command = std::find_if(experiments().begin(), experiments().end(),
                                       [&](const ExperimentInfo& info) { return info.command() == name; });
  const ExperimentInfo& info = by_command != experiments().end() ? *by_command : find_experiment(name);
  const ExperimentOptions options = options_from(info, given);
  PythonProgress progress;
  ExperimentResult result;
  {
    const py::gil_scoped_release free;
    result = info.run(options, progress);
  }
  progress.rethrow();
  py::dict tables;
  for (const NamedTable& table : result.tables) tables[py::str(table.name)] = columns_of(table.table);
  return tables;
}

py::dict run_scene(const Scene& scene) {
  PythonProgress progress;
  SimulationResult result;
  {
    const py::gil_scoped_release free;
    result = simulate(scene, progress);
  }
  progress.rethrow();
  std::vector<std::string> warnings = diagnostics_of(scene, result);
  if (result.status != Status::ok)
    throw SimulationFailed(fmt::format("{}: {} after {} steps; {}", scene.name, to_string(result.status),
                                       result.work.steps, fmt::join(warnings, "; ")));
  warnings.insert(warnings.begin(), scene.warnings.begin(), scene.warnings.end());
  py::dict found;
  found["series"] = columns_of(series_table(result.series));
  found["particles"] = columns_of(particle_table(result.particles));
  found["warnings"] = warnings;
  return found;
}

py::dict fit_scene(const fit::FitProblem& problem) {
  PythonProgress progress;
  fit::FitResult result;
  {
    const py::gil_scoped_release free;
    result = fit::fit(problem, progress);
  }
  progress.rethrow();
  py::dict found, values;
  for (std::size_t k = 0; k < result.parameters.size(); ++k)
    values[py::str(problem.parameters[k].key)] = result.parameters[k].value;
  found["status"] = fit::to_string(result.ended);
  found["values"] = values;
  for (const NamedTable& table : fit::fit_tables(problem, result))
    found[py::str(table.name)] = columns_of(table.table);
  found["chi2"] = result.chi2;
  found["degrees_of_freedom"] = result.degrees_of_freedom;
  found["evaluations"] = result.evaluations;
  found["scene"] = fit::fitted_scene(problem, result, "");
  found["warnings"] = fit::warnings_of(problem, result);
  return found;
}

}  // namespace mss::python
