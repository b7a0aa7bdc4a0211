// Ropes and sheets, lattices of one and two dimensions, beside closed forms: strings, membranes, a chain's
// dispersion relation, the catenary. Measured in runs.cpp, charts are in chart.cpp.
#include "experiments/studies/rope/rope.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace mss::studies::rope {

namespace {

constexpr const char* caption =
    "A rope of 2 m and a square sheet of 2 m, both of rubber (E = 5 MPa) and 2 cm thick, stretched by 5 "
    "percent: "
    "their frequencies beside those of the lattice (error_lattice: rounding alone) and of strings and "
    "membranes, "
    "and the speed of a pulse that is at least two links wide. A rope of 2 m that is as good as "
    "inextensible, over 1.4 m: sag and forces at "
    "its "
    "ends beside the catenary. Errors of the continuum go with the square of the cells. Left out: bending, "
    "which "
    "ropes and sheets of these springs do not resist.";

Json configuration(const RopeConfig& c) {
  return {
      {"young", c.material.young}, {"density", c.density}, {"length", c.length}, {"thickness", c.thickness},
      {"strain", c.strain},        {"stretch", c.stretch}, {"span", c.span},     {"links", c.links},
      {"squares", c.squares}};
}

double largest(const Table& rows, const char* column) {
  double most = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) most = std::max(most, rows.number(r, column));
  return most;
}

std::string summary(const RopeTables& tables) {
  std::string lines = fmt::format("frequencies beside the lattice's closed forms: error {:.1e} at most\n",
                                  largest(tables.waves, "error_lattice"));
  for (const double cells : tables.waves.distinct_numbers("cells")) {
    const Table rows = tables.waves.where("cells", cells);
    lines += fmt::format("{:>4} cells along: error of strings and membranes {:.1e} at most\n", cells,
                         largest(rows, "error_continuum"));
  }
  for (std::size_t r = 0; r < tables.catenaries.size(); ++r)
    lines += fmt::format("{:>4} links that hang: sag {:.2e}, pull {:.2e} of the catenary's wrong\n",
                         tables.catenaries.number(r, "links"), tables.catenaries.number(r, "error_sag"),
                         tables.catenaries.number(r, "error_pull"));
  return lines;
}

ExperimentResult run_ropes(const ExperimentOptions& options, Progress& progress) {
  const RopeConfig config = rope_config(options);
  RopeTables tables = measure_ropes(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables);
  result.tables = rope_files(std::move(tables));
  return result;
}

/// Values alone: errors that are rounding would differ by machine.
Table baseline_table(const BaselineOptions&, Progress& progress) {
  RopeTables tables = measure_ropes(rope_config({.quick = true}), progress);
  Table rows({{"body"}, {"quantity"}, {"cells"}, {"value"}, {"status"}});
  for (std::size_t r = 0; r < tables.waves.size(); ++r)
    rows.add({tables.waves.text(r, "body"),
              fmt::format("{} {}", tables.waves.text(r, "motion"), tables.waves.text(r, "mode")),
              tables.waves.number(r, "cells"), tables.waves.number(r, "frequency"),
              tables.waves.text(r, "status")});
  for (std::size_t r = 0; r < tables.pulses.size(); ++r)
    rows.add({std::string("rope"), std::string("pulse"), tables.pulses.number(r, "links"),
              tables.pulses.number(r, "speed"), tables.pulses.text(r, "status")});
  for (std::size_t r = 0; r < tables.catenaries.size(); ++r)
    for (const char* quantity : {"sag", "pull"})
      rows.add({std::string("catenary"), std::string(quantity), tables.catenaries.number(r, "links"),
                tables.catenaries.number(r, quantity), tables.catenaries.text(r, "status")});
  return rows;
}

}  // namespace

std::vector<NamedTable> rope_files(RopeTables tables) {
  return {{"rope", std::move(tables.waves)},
          {"rope_pulses", std::move(tables.pulses)},
          {"rope_catenaries", std::move(tables.catenaries)}};
}

ExperimentInfo experiment() {
  return {
      .name = "rope",
      .under = "validate",
      .summary = "ropes and sheets beside strings, membranes, a chain's dispersion relation, the catenary",
      .run = run_ropes,
      .draw = draw_ropes,
      .baseline = {
          .keys = {"body", "quantity", "cells"}, .rules = {{"value", 1e-7}}, .table = baseline_table}};
}

}  // namespace mss::studies::rope
