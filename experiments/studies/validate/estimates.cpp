// Estimates of errors in `mss validate`: against the references of its cases.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/studies/validate/validate.hpp"

namespace mss::studies::validate {

namespace {

void add_estimate(const ValidationConfig& config, const ValidationCase& c, const ValidationModel& model,
                  int m, Table& estimates) {
  const Body body(case_body(config, c, model, m));
  SpringSystem<double> system(body, c.environment, {.threads = config.threads});
  const GoalEstimate goal = c.estimate(system);
  const bool ok = goal.status == Status::ok;
  const double error = goal.value / c.reference - 1, corrected = goal.corrected() / c.reference - 1;
  const bool exact =
      std::abs(error) < validation_rounding && std::abs(goal.error / c.reference) < validation_rounding;
  estimates.add({c.name, model.name, m, ok ? goal.value : no_value, ok ? goal.error : no_value,
                 ok ? error : no_value, ok ? corrected : no_value,
                 ok && !exact ? goal.error / (c.reference - goal.value) : no_value, to_string(goal.doubts),
                 std::string(!ok     ? to_string(goal.status)
                             : exact ? "exact to rounding"
                                     : "ok")});
}

}  // namespace

Table empty_estimates() {
  return Table({{"case"},
                {"model"},
                {"cells"},
                {"value"},
                {"estimate"},
                {"error"},
                {"corrected_error"},
                {"effectivity"},
                {"doubts"},
                {"status"}});
}

bool measure_estimates(const ValidationConfig& config, const Progress& progress, Table& estimates) {
  for (const ValidationCase& c : config.cases)
    for (const ValidationModel& model : config.models)
      for (const int m : config.cells) {
        if (!c.estimate || !model.calibrated || m > c.most_cells) continue;
        if (progress.stopped()) return false;
        add_estimate(config, c, model, m, estimates);
      }
  return true;
}

namespace {

/// The finest number of cells that every case has.
double cells_of_all(const Table& estimates) {
  double finest = std::numeric_limits<double>::infinity();
  for (const std::string& name : estimates.distinct("case")) {
    const std::vector<double> cells = estimates.where("case", name).distinct_numbers("cells");
    finest = std::min(finest, *std::max_element(cells.begin(), cells.end()));
  }
  return finest;
}

}  // namespace

Chart estimates_chart(const Table& estimates, const Table& cases) {
  std::vector<std::string> names = estimates.distinct("case"), shown;
  for (std::string name : names) {
    if (const std::size_t end = name.find("_45"); end != std::string::npos) name.erase(end);
    std::replace(name.begin(), name.end(), '_', ' ');
    shown.push_back(
        fmt::format("{}, nu = {:g}", name, cases.where("case", names[shown.size()]).number(0, "poisson")));
  }
  const double cells = cells_of_all(estimates);
  Chart chart{
      .title = "Errors of springs, as computed and corrected by their estimate",
      .subtitle = fmt::format("{:g} cells across the width; what is exact to rounding is left out", cells),
      .x = {.label = "relative error", .logarithmic = true},
      .y = named_rows(shown)};
  const std::vector<std::string> models = estimates.distinct("model");
  for (const std::string& model : models)
    for (const char* column : {"error", "corrected_error"}) {
      ChartSeries series{.label = model + (column == std::string("error") ? ": as computed" : ": corrected"),
                         .joined = false};
      const Table of_model = estimates.where("model", model).where("cells", cells).where("status", "ok");
      for (std::size_t i = 0; i < names.size(); ++i)
        if (const Table run = of_model.where("case", names[i]); run.size() > 0)
          if (const double error = std::abs(run.number(0, column)); error > validation_rounding)
            series.points.push_back({error, chart.y.ticks[i]});
      chart.series.push_back(std::move(series));
    }
  return chart;
}

}  // namespace mss::studies::validate
