// The silicone fitted to two of the measured runs; what it predicts of the other four is in runs.cpp.
#include <fmt/format.h>

#include <utility>

#include "core/base/error.hpp"
#include "experiments/fit/fit.hpp"
#include "experiments/fit/report.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/studies/beam/beam.hpp"
#include "reference/beam/beam.hpp"

namespace mss::studies::beam {

namespace {

/// What is fitted of a material, and where from.
struct FittedForm {
  std::string name;
  std::vector<std::string> parameters, starts;
};

const std::vector<FittedForm>& fitted_forms() {
  static const std::vector<FittedForm> forms{
      {"fitted, one Maxwell branch",
       {"material.young", "damping.viscosity=1..2000", "material.relaxation.ratio=0.01..2",
        "material.relaxation.time=0.005..2"},
       {"damping.viscosity=60", "material.relaxation.ratio=0.25", "material.relaxation.time=0.04"}},
      {"fitted, Kelvin-Voigt", {"material.young", "damping.viscosity=1..2000"}, {}}};
  return forms;
}

/// Rings in the steps that it was fitted with: explicit ones take eight times as long, for frequencies .15
/// percent and damping ratios .0007 apart, 6 cells across.
const std::vector<std::string> fitted_steps{"solve.integrator=tr_bdf2/lbfgs:5", "solve.dt=0.0025"};

constexpr int twin_cells = 3;

fit::FitProblem fit_problem(const FittedForm& form, int cells) {
  const fit::SceneSource source = fit::source_of(scene_file(beam_loads().front().scene));
  std::vector<std::string> settings = beam_cells(cells);
  settings.insert(settings.end(), form.starts.begin(), form.starts.end());
  fit::FitProblem problem = fit::read_problem(source, settings, form.parameters);
  problem.data = fit::read_observations_text(reference::beam_runs_to_fit_text(), source, settings);
  if (cells > twin_cells) problem.coarse = beam_cells(twin_cells);
  fit::check_problem(problem);
  return problem;
}

void add_rows(const FittedForm& form, int cells, const fit::FitProblem& problem, const fit::FitResult& result,
              Table& rows) {
  for (std::size_t k = 0; k < result.parameters.size(); ++k) {
    const fit::FittedParameter& p = result.parameters[k];
    const std::string status = result.ended == fit::Ended::converged ? p.status : to_string(result.ended);
    rows.add({form.name, cells, problem.parameters[k].key, problem.parameters[k].start, p.value, p.low,
              p.high, result.chi2, std::int64_t(result.degrees_of_freedom), result.evaluations,
              std::int64_t(result.runs), std::int64_t(result.coarse_runs), result.seconds, status});
  }
}

}  // namespace

Table empty_beam_fits() {
  return Table({{"material"},
                {"cells"},
                {"parameter"},
                {"start"},
                {"fitted"},
                {"low"},
                {"high"},
                {"chi2"},
                {"degrees_of_freedom"},
                {"evaluations"},
                {"runs"},
                {"coarse_runs"},
                {"seconds", "s"},
                {"status"}});
}

std::vector<BeamMaterial> fit_beam(int cells, Progress& progress, Table& fits) {
  std::vector<BeamMaterial> materials;
  const auto forms = double(fitted_forms().size());
  for (const FittedForm& form : fitted_forms()) {
    const auto before = double(materials.size());
    PartProgress of_form(progress, before / forms, (before + 1) / forms);
    const fit::FitProblem problem = fit_problem(form, cells);
    const fit::FitResult result = fit::fit(problem, of_form);
    if (progress.stopped()) break;
    add_rows(form, cells, problem, result, fits);
    std::vector<double> values;
    for (const fit::FittedParameter& p : result.parameters) values.push_back(p.value);
    std::vector<std::string> settings = form.starts;
    for (std::string& setting : fit::settings_of(problem, values)) settings.push_back(std::move(setting));
    settings.insert(settings.end(), fitted_steps.begin(), fitted_steps.end());
    materials.push_back({form.name, std::move(settings), cells});
  }
  return materials;
}

}  // namespace mss::studies::beam
