#include "experiments/fit/report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/measures/measures.hpp"
#include "core/scene/scene_writer.hpp"
#include "experiments/fit/chart.hpp"
#include "experiments/harness/drawings.hpp"
#include "experiments/harness/results_folder.hpp"
#include "experiments/io/output.hpp"

namespace mss::fit {

namespace {

namespace fs = std::filesystem;

Table parameter_table(const FitProblem& problem, const FitResult& result) {
  Table table({{"parameter"}, {"start"}, {"fitted"}, {"low"}, {"high"}, {"at_bound"}, {"status"}});
  for (std::size_t k = 0; k < result.parameters.size(); ++k) {
    const FittedParameter& p = result.parameters[k];
    const std::string status = std::isfinite(p.low) || p.status != "ok" ? p.status : to_string(result.ended);
    table.add({problem.parameters[k].key, problem.parameters[k].start, p.value, p.low, p.high,
               std::int64_t(p.at_bound), status});
  }
  return table;
}

/// Of what an observation is a number of.
std::string unit_of(const Observation& o) {
  if (o.kind == Kind::frequency) return "Hz";
  if (o.kind == Kind::damping) return "";
  if (o.point) return "m";
  for (const MeasureColumn& column : measure_columns)
    if (column.name == o.column) return std::string(column.unit);
  return "N";  // of holds and planes
}

Table data_table(const FitProblem& problem, const FitResult& result) {
  Table table({{"observation"},
               {"kind"},
               {"scene"},
               {"column"},
               {"unit"},
               {"time", "s"},
               {"measured"},
               {"fitted"},
               {"residual"},
               {"uncertainty"}});
  for (std::size_t k = 0; k < result.fitted.size(); ++k) {
    const Observation& o = problem.data.observations[k];
    for (std::size_t i = 0; i < o.measured.size(); ++i)
      table.add({o.name, to_string(o.kind), problem.data.runs[o.run].name, o.column, unit_of(o),
                 o.times.empty() ? 0 : o.times[i], o.measured[i], result.fitted[k][i],
                 o.measured[i] - result.fitted[k][i], o.uncertainty});
  }
  return table;
}

Table correlation_table(const FitProblem& problem, const FitResult& result) {
  Table table({{"parameter"}, {"other"}, {"correlation"}, {"status"}});
  for (Eigen::Index i = 0; i < result.correlation.rows(); ++i)
    for (Eigen::Index j = i + 1; j < result.correlation.cols(); ++j) {
      const double c = result.correlation(i, j);
      table.add({problem.parameters[std::size_t(i)].key, problem.parameters[std::size_t(j)].key, c,
                 std::string(std::isfinite(c) ? "ok" : "one of them has no interval")});
    }
  return table;
}

Table step_table(const FitProblem& problem, const FitResult& result) {
  std::vector<Column> columns{{"kind"}, {"evaluations"}, {"chi2"}, {"accepted"}};
  for (const Parameter& p : problem.parameters) columns.push_back({p.key});
  columns.push_back({"status"});
  Table table(std::move(columns));
  for (const TriedStep& step : result.steps) {
    std::vector<Cell> row{step.kind, step.evaluations, step.chi2, std::int64_t(step.accepted)};
    for (const double value : values_of(problem, step.u)) row.emplace_back(value);
    const bool is_part = step.kind.ends_with("difference");  // it has no sum of its own
    row.emplace_back(!step.problem.empty() ? step.problem
                                           : std::string(is_part ? "one parameter moved" : "ok"));
    table.add(std::move(row));
  }
  return table;
}

std::vector<double> values_in(const FitResult& result) {
  std::vector<double> values;
  for (const FittedParameter& p : result.parameters) values.push_back(p.value);
  return values;
}

Json meta(const FitProblem& problem, const FitResult& result, const std::vector<NamedTable>& tables,
          const Json& origin) {
  Json runs = Json::array();
  for (const RunSpec& run : problem.data.runs) runs.push_back(run.name);
  return {{"experiment", "fit"},
          {"scene", problem.scene.name},
          {"status", to_string(result.ended)},
          {"settings", settings_of(problem, values_in(result))},
          {"chi2", result.chi2},
          {"degrees_of_freedom", result.degrees_of_freedom},
          {"evaluations", result.evaluations},
          {"runs", result.runs},
          {"coarse", problem.coarse},
          {"coarse_runs", result.coarse_runs},
          {"scenes", runs},
          {"seconds", result.seconds},
          {"warnings", warnings_of(problem, result)},
          {"configuration", to_json(problem.scene)},
          {"tables", describe_tables(tables)},
          {"provenance", origin}};
}

std::string interval_in_words(const FittedParameter& p) {
  if (!std::isfinite(p.low)) return p.status;
  return fmt::format("95 %: {:.5g} to {:.5g}{}", p.low, p.high, p.status == "ok" ? "" : ", " + p.status);
}

std::string in_words(const Observation& o, const std::vector<double>& fitted) {
  std::string text = "  " + o.name;
  if (o.kind != Kind::series && o.measured[0] != 0) {
    text += fmt::format(": {:.5g} measured, {:.5g} fitted ({:+.2f} %)", o.measured[0], fitted[0],
                        100 * (fitted[0] / o.measured[0] - 1));
  } else {
    double square = 0;
    for (std::size_t i = 0; i < fitted.size(); ++i) square += std::pow(fitted[i] - o.measured[i], 2);
    const std::string unit = unit_of(o).empty() ? "" : " " + unit_of(o);
    text += fmt::format(": {} number{}, off by {:.3g}{} in the root mean square", fitted.size(),
                        fitted.size() == 1 ? "" : "s", std::sqrt(square / double(fitted.size())), unit);
  }
  if (o.apart > 0) text += fmt::format("; what is followed is {:.2g} m from the point", o.apart);
  return text + "\n";
}

}  // namespace

std::string to_string(Ended ended) {
  switch (ended) {
    case Ended::converged:
      return "converged";
    case Ended::too_many_evaluations:
      return "not converged: no evaluations are left";
    case Ended::stalled:
      return "not converged: no smaller step is better";
    case Ended::undetermined:
      return "not determined by the data";
    case Ended::failed_at_start:
      return "failed at the start";
    case Ended::interrupted:
      return "interrupted";
  }
  return {};
}

std::vector<NamedTable> fit_tables(const FitProblem& problem, const FitResult& result) {
  return {{"fit", parameter_table(problem, result)},
          {"fit_data", data_table(problem, result)},
          {"fit_correlation", correlation_table(problem, result)},
          {"fit_steps", step_table(problem, result)}};
}

std::string fitted_scene(const FitProblem& problem, const FitResult& result, const fs::path& folder) {
  const std::vector<std::string> settings = settings_of(problem, values_in(result));
  return fmt::format("# {} with the values that `mss fit` found: {}.\n", problem.scene.name,
                     fmt::join(settings, ", ")) +
         to_toml(problem.source.load(settings), folder);
}

void write_fit(const FitProblem& problem, const FitResult& result, const Json& origin,
               const fs::path& directory) {
  const std::vector<NamedTable> tables = fit_tables(problem, result);
  for (const NamedTable& table : tables)
    write_atomically(directory / (table.name + ".csv"), table.table.csv());
  write_atomically(directory / "meta.json", meta(problem, result, tables, origin).dump(2) + "\n");
  const fs::path scene = directory / (problem.scene.name + "_fitted.toml");
  if (result.parameters.empty())
    fs::remove(scene);
  else
    write_atomically(scene, fitted_scene(problem, result, directory));
  write_drawings(draw(tables), tables, origin, directory);
}

std::vector<std::string> warnings_of(const FitProblem& problem, const FitResult& result) {
  std::vector<std::string> warnings;
  if (result.ended != Ended::converged) warnings.push_back("the fit has " + to_string(result.ended));
  for (std::size_t k = 0; k < result.parameters.size(); ++k)
    if (result.parameters[k].at_bound)
      warnings.push_back(fmt::format("{} ends at its bound, {:.6g}: the data would have it beyond",
                                     problem.parameters[k].key, result.parameters[k].value));
  for (Eigen::Index i = 0; i < result.correlation.rows(); ++i)
    for (Eigen::Index j = i + 1; j < result.correlation.cols(); ++j)
      if (std::abs(result.correlation(i, j)) > 0.99)
        warnings.push_back(fmt::format("{} and {} are hardly told apart: their correlation is {:.4f}",
                                       problem.parameters[std::size_t(i)].key,
                                       problem.parameters[std::size_t(j)].key, result.correlation(i, j)));
  for (std::size_t k = 0; k < result.parameters.size(); ++k) {
    const FittedParameter& p = result.parameters[k];
    if (p.status.starts_with("hardly"))
      warnings.push_back(fmt::format("{} is {}, which allow {:.2g} to {:.2g}", problem.parameters[k].key,
                                     p.status, p.low, p.high));
  }
  const auto failed = std::count_if(result.steps.begin(), result.steps.end(),
                                    [](const TriedStep& step) { return !step.problem.empty(); });
  if (failed > 0)
    warnings.push_back(fmt::format("{} trial{} failed, and the step was halved; fit_steps.csv says why",
                                   failed, failed == 1 ? "" : "s"));
  return warnings;
}

std::string summary(const FitProblem& problem, const FitResult& result) {
  std::string text = fmt::format(
      "{}: {} after {:.3g} evaluations ({} runs of scenes{}) in {:.3g} s\n", problem.scene.name,
      to_string(result.ended), result.evaluations, result.runs,
      problem.coarse.empty() ? "" : fmt::format(", {} of coarse ones", result.coarse_runs), result.seconds);
  for (std::size_t k = 0; k < result.parameters.size(); ++k)
    text += fmt::format("  {} = {:.6g}  ({}; start {:.6g})\n", problem.parameters[k].key,
                        result.parameters[k].value, interval_in_words(result.parameters[k]),
                        problem.parameters[k].start);
  for (Eigen::Index i = 0; i < result.correlation.rows(); ++i)
    for (Eigen::Index j = i + 1; j < result.correlation.cols(); ++j)
      if (std::isfinite(result.correlation(i, j)))
        text += fmt::format("  correlation of {} and {}: {:.3f}\n", problem.parameters[std::size_t(i)].key,
                            problem.parameters[std::size_t(j)].key, result.correlation(i, j));
  for (std::size_t k = 0; k < result.fitted.size(); ++k)
    text += in_words(problem.data.observations[k], result.fitted[k]);
  if (!result.parameters.empty())
    text +=
        fmt::format("  chi2 {:.4g}, {} degree{} of freedom{}\n", result.chi2, result.degrees_of_freedom,
                    result.degrees_of_freedom == 1 ? "" : "s",
                    result.degrees_of_freedom == 0 ? ": as many numbers as parameters, so nothing says how "
                                                     "certain these are"
                                                   : "");
  return text;
}

}  // namespace mss::fit
