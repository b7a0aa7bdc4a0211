// The thesis's remaining figures and sentences, one by one: crumpling (Fig. 2-1), direction (Fig. 2-2), the
// price of exact volumes (3.1), what the volume force does to shape (chapter 3, eq. 1-2), Fig. 5-1, Fig. 5-4
// and its remedies (5.2.2), frames a second (5.2.1). reference/THESIS.md has them all.
#include "experiments/studies/thesis/thesis.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "experiments/simulation/model.hpp"

namespace mss::studies::thesis {

namespace {

constexpr const char* caption =
    "Unloading: the thesis's cube of 3 x 3 x 3 cells, springs shared uniformly, damping ratio 0.3, between "
    "plates of "
    "which the upper one moves in a second; both are then removed. Deformation is the root mean square "
    "distance from "
    "the rest shape after the best rigid motion. Twist: the scene fig5_1_twist in finer cells, springs "
    "proportional "
    "to the cell's size. Landings: 3 x 3 x 3 cells of 0.2 m, damping ratio 0.05, no gravity, restitution "
    "0.5, "
    "friction 0.4, a tenth of the stable step of verlet; recovered: no cell is inverted at the end. Shape: a "
    "cube "
    "glued to plates and stretched; volume corrected is the share of its change of volume that the volume "
    "force "
    "undoes, change of shape the root mean square difference of displacements over that of the displacements "
    "without the force. Frames: mss view draws every frame of 1/60 s of the scene fig5_2_bounce, material "
    "constant, "
    "1280 x 800 pixels. Times belong to this machine.";

Json configuration(const ThesisConfig& c) {
  Json deformations = Json::array(), landings = Json::array();
  for (const Deformation& d : c.deformations) deformations.push_back(d.name);
  for (const LandingCase& l : c.landing_cases) landings.push_back(l.name);
  return {{"deformations", deformations},
          {"direction_cells", c.direction_cells},
          {"volume_shares", c.volume_shares},
          {"shape_cells", c.shape_cells},
          {"shape_strain", c.shape_strain},
          {"twist_cells", c.twist_cells},
          {"twist_angle", c.twist_angle},
          {"landings", landings},
          {"landing_speeds", c.landing_speeds},
          {"frame_cells", c.frame_cells},
          {"frames", c.frames},
          {"timing_repetitions", c.timing_repetitions},
          {"threads", c.threads}};
}

/// A table of the study and what measures it.
struct Part {
  const char* name;
  std::function<Table(const ThesisConfig&, Progress&)> measure;
};

const std::vector<Part>& parts() {
  static const std::vector<Part> all{
      {"thesis_unloading", measure_unloading},
      {"thesis_directions", measure_directions},
      {"thesis_figure_5_1", [](const ThesisConfig&, const Progress& p) { return measure_figure_5_1(p); }},
      {"thesis_twist", measure_twists},
      {"thesis_volume_time", measure_volume_time},
      {"thesis_shape", measure_shape},
      {"thesis_landing", measure_landings},
      {"thesis_frames", measure_frames}};
  return all;
}

std::string in_words(double value) { return std::isnan(value) ? "none" : fmt::format("{:.4g}", value); }

ExperimentResult run_thesis(const ExperimentOptions& options, Progress& progress) {
  const ThesisConfig config = thesis_config(options);
  ExperimentResult result{.caption = caption, .configuration = configuration(config)};
  std::vector<NamedTable> tables;
  for (const Part& part : parts()) {
    const double done = double(tables.size()), all = double(parts().size());
    progress.report(done / all, part.name);
    PartProgress of_part(progress, done / all, (done + 1) / all);
    tables.push_back({part.name, part.measure(config, of_part)});
  }
  if (progress.stopped()) result.status = Status::interrupted;
  const Table summary = summary_table(tables);
  for (std::size_t r = 0; r < summary.size(); ++r)
    result.summary += fmt::format("{:<13} {:<64} {:>11}   {} {}\n", summary.text(r, "item"),
                                  summary.text(r, "quantity"), in_words(summary.number(r, "value")),
                                  summary.text(r, "beside"), in_words(summary.number(r, "other")));
  result.tables.push_back({"thesis", summary});
  for (NamedTable& table : tables) result.tables.push_back(std::move(table));
  return result;
}

}  // namespace

ThesisConfig thesis_config(const ExperimentOptions& options) {
  const bool quick = options.quick;
  ThesisConfig config;
  config.deformations = {{"sheared by 0.3", {0.3, 0, 0}, 0},
                         {"sheared by 1", {1, 0, 0}, 0},
                         {"pressed to 0.5", {0, 0, -0.5}, 0},
                         {"twisted by 45 degrees", {0, 0, 0}, 45},
                         {"twisted by 90 degrees", {0, 0, 0}, 90}};
  config.direction_cells = quick ? std::vector<int>{2, 4} : std::vector<int>{4, 8};
  config.volume_shares = quick ? std::vector<double>{0, 1, 10}
                               : std::vector<double>{0, 1e-4, 1e-3, 1e-2, 0.1, 0.3, 1, 3, 10, 30, 100};
  config.shape_cells = quick ? 3 : 6;
  config.twist_cells = quick ? std::vector<int>{5, 10} : std::vector<int>{5, 7, 10};
  config.twist_angle = quick ? 60 : 90;
  config.landing_cases = {{"Algorithm 2"},
                          {.name = "law impulse", .contact = ContactLaw::impulse},
                          {.name = "step / 10", .step = 0.1},
                          {.name = "body diagonals x 4", .body = 4},
                          {.name = "all springs x 4", .all = 4},
                          {.name = "fold guard", .fold_guard = default_fold_guard}};
  if (quick) {
    std::erase_if(config.deformations, [](const Deformation& d) { return d.turn > 45 || d.shift[0] > 0.5; });
    std::erase_if(config.landing_cases, [](const LandingCase& c) { return c.step < 1; });
  }
  for (double speed = 5; speed <= 500; speed *= quick ? 4 : 1.2) config.landing_speeds.push_back(speed);
  config.frame_cells = quick ? std::vector<int>{7} : std::vector<int>{3, 5, 7, 10, 15, 20, 30};
  config.frames = quick ? 10 : 60;
  config.timing_repetitions = quick ? 5 : 25;
  return config;
}

namespace {

/// The numbers of a table in one column each, named by the keys of their row.
void flatten(const NamedTable& named, const std::vector<std::string>& keys,
             const std::vector<std::string>& columns, Table& rows) {
  for (std::size_t r = 0; r < named.table.size(); ++r) {
    std::string row;
    for (const std::string& key : keys) {
      const auto& names = named.table.columns();
      for (std::size_t c = 0; c < names.size(); ++c) {
        if (names[c].name != key) continue;
        const Cell& cell = named.table.rows()[r][c];
        row += (row.empty() ? "" : ", ") + (std::holds_alternative<std::string>(cell)
                                                ? std::get<std::string>(cell)
                                                : fmt::format("{:g}", named.table.number(r, key)));
      }
    }
    for (const std::string& column : columns)
      rows.add({named.name, row, column, named.table.number(r, column), named.table.text(r, "status")});
  }
}

/// What does not hang on rounding: folded states, pressed cubes, which buckle, and times are left out.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  ThesisConfig config = thesis_config({.quick = true});
  config.threads = options.threads;
  config.twist_cells = {5};
  if (options.quick) config.volume_shares = {0, 1};
  Table rows({{"table"}, {"row"}, {"column"}, {"value"}, {"status"}});
  const Table unloading = measure_unloading(config, progress);
  flatten({"unloading", unloading}, {"springs", "deformation"}, {"mechanisms"}, rows);
  for (const char* deformation : {"sheared by 0.3", "twisted by 45 degrees"})
    flatten({"unloading", unloading.where("deformation", deformation)}, {"springs", "deformation"},
            {"loaded"}, rows);
  flatten({"unloading", unloading.where("springs", "full").where("deformation", "sheared by 0.3")},
          {"springs", "deformation"}, {"remaining"}, rows);
  flatten({"directions", measure_directions(config, progress)},
          {"cells", "material", "springs", "modulus", "direction"}, {"measured", "closed_form"}, rows);
  flatten({"figure_5_1", measure_figure_5_1(progress)}, {"scene"},
          {"volume_ratio", "volume_ratio_estimate", "worst_cell_error", "min_jacobian", "max_stretch"}, rows);
  flatten({"shape", measure_shape(config, progress)}, {"case", "k_vol_over_shear"},
          {"alpha", "volume_change", "shape_change", "step_over_plain"}, rows);
  return rows;
}

}  // namespace

ExperimentInfo experiment() {
  return {
      .name = "thesis",
      .summary =
          "the thesis's remaining figures and sentences: crumpling, direction, volume against shape, twists "
          "and landings that fold, frames a second",
      .run = run_thesis,
      .draw = draw_thesis,
      .baseline = {
          .keys = {"table", "row", "column"}, .rules = {{"value", 1e-6, 1e-9}}, .table = baseline_table}};
}

}  // namespace mss::studies::thesis
