#include "reference/beam/beam.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace mss::reference {

// Generated from the tables beside this file.
extern const char* const beam_measured;
extern const char* const beam_comsol;
extern const char* const beam_marker_table;
extern const char* const beam_runs_to_fit;

namespace {

/// Lines after the header, split at commas.
std::vector<std::vector<std::string>> beam_rows(const char* table) {
  std::istringstream lines(table);
  std::string line, cell;
  std::getline(lines, line);
  std::vector<std::vector<std::string>> rows;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::vector<std::string>& row = rows.emplace_back();
    while (std::getline(cells, cell, ',')) row.push_back(cell);
  }
  return rows;
}

std::vector<BeamValue> beam_values(const char* table) {
  std::vector<BeamValue> values;
  for (const auto& row : beam_rows(table)) values.push_back({row.at(0), row.at(1), std::stod(row.at(2))});
  return values;
}

std::vector<BeamMarker> read_markers() {
  std::vector<BeamMarker> markers;
  for (const auto& row : beam_rows(beam_marker_table))
    markers.push_back({std::stoi(row.at(0)),
                       {std::stod(row.at(1)), std::stod(row.at(2)), std::stod(row.at(3))},
                       {0, std::stod(row.at(4)), std::stod(row.at(5))}});
  return markers;
}

}  // namespace

const std::vector<BeamValue>& measured_beam() {
  static const std::vector<BeamValue> rows = beam_values(beam_measured);
  return rows;
}

const std::vector<BeamValue>& comsol_beam() {
  static const std::vector<BeamValue> rows = beam_values(beam_comsol);
  return rows;
}

double beam_value(const std::vector<BeamValue>& rows, std::string_view run, std::string_view quantity) {
  for (const BeamValue& row : rows)
    if (row.run == run && row.quantity == quantity) return row.value;
  return std::numeric_limits<double>::quiet_NaN();
}

const std::vector<BeamMarker>& beam_markers() {
  static const std::vector<BeamMarker> markers = read_markers();
  return markers;
}

std::vector<BeamTurn> beam_turns(std::string_view run) {
  std::vector<BeamTurn> turns;
  for (int n = 1;; ++n) {
    const double time = beam_value(measured_beam(), run, fmt::format("extremum_{}_s", n));
    if (std::isnan(time)) return turns;
    turns.push_back({time, 1e-3 * beam_value(measured_beam(), run, fmt::format("extremum_{}_mm", n))});
  }
}

const char* beam_runs_to_fit_text() { return beam_runs_to_fit; }

}  // namespace mss::reference
