// Charts of `mss thesis`, from its tables, and the table that gathers its numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/studies/thesis/thesis.hpp"

namespace mss::studies::thesis {

namespace {

/// What remains of every deformation, a row each.
Chart unloading_chart(const Table& rows) {
  const std::vector<std::string> deformations = rows.distinct("deformation");
  Chart chart{.title = "What remains of a deformation when the load is gone (Fig. 2-1)",
              .subtitle = "the thesis's cube of 3 x 3 x 3 cells with all and with fewer springs, released",
              .x = {.label = "remaining / loaded deformation", .low = -0.05},
              .y = named_rows(deformations)};
  for (const std::string& springs : rows.distinct("springs")) {
    ChartSeries series{.label = springs, .joined = false};
    const Table of_springs = rows.where("springs", springs);
    for (std::size_t r = 0; r < of_springs.size(); ++r) {
      const auto at = std::find(deformations.begin(), deformations.end(), of_springs.text(r, "deformation"));
      if (of_springs.text(r, "status") == "ok")
        series.points.push_back(
            {of_springs.number(r, "share"), chart.y.ticks[std::size_t(at - deformations.begin())]});
      else
        series.label += fmt::format(" ({}: {})", *at, of_springs.text(r, "status"));
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart twist_chart(const Table& rows) {
  Chart chart{
      .title = "Folding of the twisted cube (Fig. 5-1)",
      .subtitle =
          "the thesis's cube in n cells per edge, material constant; Fig. 5-1 shows 60 degrees; below 0 a "
          "cell is inverted",
      .x = {.label = "angle of the upper face [degrees]", .ticks = {0, 15, 30, 45, 60, 75, 90}},
      .y = {.label = "smallest corner volume / that at rest"},
      .lines = {{ReferenceLine::Direction::horizontal, 0, ""}, {ReferenceLine::Direction::vertical, 60, ""}}};
  for (const bool guarded : {false, true})
    for (const double n : rows.distinct_numbers("cells")) {
      const Table run = rows.where("cells", n).where("guarded", guarded ? 1.0 : 0.0);
      ChartSeries series{.label = fmt::format("n = {:g}{}", n, guarded ? ", fold guard" : "")};
      for (std::size_t r = 0; r < run.size(); ++r)
        if (run.text(r, "status") == "ok")
          series.points.push_back({run.number(r, "angle"), run.number(r, "min_jacobian")});
        else
          series.label += fmt::format(" ({} at {:g})", run.text(r, "status"), run.number(r, "angle"));
      chart.series.push_back(std::move(series));
    }
  return chart;
}

Chart shape_chart(const Table& rows) {
  Chart chart{.title = "Change of shape against corrected volume (chapter 3)",
              .subtitle = "cube of 1 m glued to plates and stretched; along each line k_vol grows from 0",
              .x = {.label = "share of the change of volume that the force undoes"},
              .y = {.label = "change of shape: rms / rms displacement", .low = 0}};
  for (const std::string& name : rows.distinct("case")) {
    ChartSeries series{.label = name};
    const Table of_case = rows.where("case", name);
    for (std::size_t r = 0; r < of_case.size(); ++r)
      if (of_case.text(r, "status") == "ok")
        series.points.push_back({of_case.number(r, "volume_corrected"), of_case.number(r, "shape_change")});
      else
        series.label +=
            fmt::format(" ({} at {:g} mu)", of_case.text(r, "status"), of_case.number(r, "k_vol_over_shear"));
    chart.series.push_back(std::move(series));
  }
  return chart;
}

/// An outcome of landings as the legend shows it.
struct OutcomeSeries {
  const char* outcome;
  const char* label;
  int style;
};

Chart landing_chart(const Table& rows) {
  std::vector<std::string> names;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (const std::string name = rows.text(r, "case") + ", " + rows.text(r, "landing");
        names.empty() || names.back() != name)
      names.push_back(name);
  Chart chart{.title = "Landings that fold the thesis's cube, and remedies (Fig. 5-4, 5.2.2)",
              .subtitle = "3 x 3 x 3 cells; Algorithm 2 and verlet where nothing else is said",
              .x = {.label = "landing speed [m/s]",
                    .logarithmic = true,
                    .low = 4,
                    .ticks = {5, 10, 20, 50, 100, 200, 500}},
              .y = named_rows(names)};
  for (const OutcomeSeries& kind :
       {OutcomeSeries{"recovered", "recovers", 9}, OutcomeSeries{"trapped", "stays folded", 0},
        OutcomeSeries{"moving", "folded, still moving", 7},
        OutcomeSeries{"non_finite", "numbers not finite", 15}}) {
    ChartSeries series{.label = kind.label, .style = kind.style, .joined = false};
    for (std::size_t r = 0; r < rows.size(); ++r)
      if (rows.text(r, "outcome") == kind.outcome) {
        const auto row =
            std::find(names.begin(), names.end(), rows.text(r, "case") + ", " + rows.text(r, "landing"));
        series.points.push_back({rows.number(r, "speed"), chart.y.ticks[std::size_t(row - names.begin())]});
      }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

Drawings draw_thesis(const std::vector<NamedTable>& tables) {
  Drawings drawings;
  const auto add = [&](const char* name, const char* table, Chart (*chart)(const Table&)) {
    if (const Table& rows = find_table(tables, table); rows.size() > 0)
      drawings.charts.push_back({name, chart(rows), table});
  };
  add("thesis", "thesis_unloading", unloading_chart);
  add("thesis_twist", "thesis_twist", twist_chart);
  add("thesis_shape", "thesis_shape", shape_chart);
  add("thesis_landing", "thesis_landing", landing_chart);
  return drawings;
}

}  // namespace mss::studies::thesis
