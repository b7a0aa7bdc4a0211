// A silicone beam beside its measurement (reference/beam): how far it sinks under three weights, at which
// frequency it rings and how fast that decays, with the spread of the repetitions beside every error and
// COMSOL's values beside ours. Runs are in runs.cpp, charts in chart.cpp.
#include "experiments/studies/beam/beam.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.hpp"

namespace mss::studies::beam {

namespace {

constexpr int most_fit_cells = 12;  ///< across: about a minute on two cores, of 18 several

Json beam_configuration(const BeamConfig& config) {
  Json materials = Json::object(), scenes = Json::object(), ringing = Json::array();
  for (const BeamMaterial& material : config.materials) materials[material.name] = material.settings;
  for (const BeamLoad& load : beam_loads()) scenes[load.name] = load.scene;
  for (const BeamLoad& load : config.ringing) ringing.push_back(load.name);
  return {{"materials", materials},
          {"scenes", scenes},
          {"cells", config.cells},
          {"ringing", ringing},
          {"ringing_cells", config.ringing_cells},
          {"settings", config.settings},
          {"fit_cells", config.fit_cells},
          {"ringing_turns", ringing_turns}};
}

constexpr const char* beam_caption =
    "A beam of Dragon Skin 10 silicone, 0.1 x 0.03 x 0.03 m, clamped at one end, held level and let go; "
    "weights of 0, 52 and 102 g hang at the top edge of its free end. Measured by motion capture at 100 "
    "Hz (Dubied et al. 2022, reference/beam), each load twice, a and b. Drops are of the three points "
    "of the end face that are nearest to markers, at rest; drop_of_centre is of the marker's centre, 6 "
    "mm off, which turns with the end face. Errors are computed over measured less one; spread is run b "
    "over run a less one, so what is within it is not an error that the measurement shows. COMSOL's "
    "values are its users', with E = 263,824 Pa; of two markers they are known with 52 g only. E is what "
    "its authors fitted to where it rests, the density is as published, nu is 0.495, where 0.499 was "
    "published; nothing of that material is fitted here but the viscosity, to the damping of run a without a "
    "weight. Fitted materials are, as mss fit does it "
    "(reference/beam/fit_a.toml), to where marker 1 rests, its frequency and the damping of its swings in "
    "runs a without a weight and with 102 g, so that the other four runs are predicted: E and viscosity "
    "alone (Kelvin-Voigt), and with one Maxwell branch a spring; they ring in steps of 2.5 ms of TR-BDF2. "
    "Frequencies and damping ratios, measured "
    "and computed, are of the first eight turning points: the time from one to the next, the decrement of "
    "upper peaks about the rest, and that of swings, which a rest that drifts does not change. "
    "Times begin when marker 1 has moved 0.3 mm. The damping ratio of a Kelvin-Voigt solid grows as its "
    "frequency; the measured one does not, and the measured rest drifts by up to a tenth of the drop "
    "while it rings: the silicone relaxes. Left out: how the hand let go, how the weight hangs, "
    "markers' masses, other shapes and materials. Runs share the cores, with one thread each, so their "
    "seconds are no measure of cost. One branch makes a material stiffer the faster it moves; "
    "the square of the measured frequency over ours as published does not grow with frequency, so something "
    "else acts too: a weight that swings on its thread, masses of markers, or strains, which are the largest "
    "where the frequency is lowest.";

std::string percent(double share) { return fmt::format("{:+.1f} %", 100 * share); }

std::string fit_lines(const Table& fits) {
  std::string lines;
  for (std::size_t r = 0; r < fits.size(); ++r)
    lines += fmt::format("{}: {} = {:.5g} (95 %: {:.3g} to {:.3g}), {}\n", fits.text(r, "material"),
                         fits.text(r, "parameter"), fits.number(r, "fitted"), fits.number(r, "low"),
                         fits.number(r, "high"), fits.text(r, "status"));
  for (const std::string& material : fits.distinct("material")) {
    const Table of = fits.where("material", material);
    lines += fmt::format("{}: {:g} evaluations in {:.0f} s, {:g} cells across\n", material,
                         of.number(0, "evaluations"), of.number(0, "seconds"), of.number(0, "cells"));
  }
  return lines;
}

std::string drop_lines(const Table& drops) {
  std::string lines;
  const Table marker = drops.where("marker", 1);
  for (std::size_t r = 0; r < marker.size(); ++r)
    lines += marker.text(r, "status") == "ok"
                 ? fmt::format(
                       "{}, {:<5} {:>2} cells across: marker 1 sinks {:.2f} mm, {} and {} of runs a and b "
                       "(b over a {})\n",
                       marker.text(r, "material"), marker.text(r, "load"), marker.number(r, "cells"),
                       marker.number(r, "drop"), percent(marker.number(r, "error_a")),
                       percent(marker.number(r, "error_b")), percent(marker.number(r, "spread")))
                 : fmt::format("{}, {:<5} {:>2} cells across: {}\n", marker.text(r, "material"),
                               marker.text(r, "load"), marker.number(r, "cells"), marker.text(r, "status"));
  return lines;
}

std::string ring_down_lines(const Table& rows) {
  std::string lines;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto number = [&](const char* column) { return rows.number(r, column); };
    const std::string what = fmt::format("{}, {:<5} {:>2} cells across: ", rows.text(r, "material"),
                                         rows.text(r, "load"), number("cells"));
    if (rows.text(r, "status") != "ok")
      lines += what + rows.text(r, "status") + "\n";
    else
      lines += what + fmt::format(
                          "{:.2f} Hz, {} and {} of runs a and b; damping ratio {:.1f} %, measured {:.1f} "
                          "and {:.1f} %\n",
                          number("frequency"), percent(number("frequency_error_a")),
                          percent(number("frequency_error_b")), 100 * number("damping_ratio"),
                          100 * number("damping_ratio_a"), 100 * number("damping_ratio_b"));
  }
  return lines;
}

ExperimentResult run_beam(const ExperimentOptions& options, Progress& progress) {
  const BeamConfig config = beam_config(options);
  BeamTables tables = measure_beam(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = beam_caption, .configuration = beam_configuration(config)};
  result.summary = fit_lines(tables.fits) + drop_lines(tables.drops) + ring_down_lines(tables.ring_down);
  result.tables = beam_files(std::move(tables));
  return result;
}

/// Drops, frequencies and damping ratios, where they are the same on every machine.
Table beam_baseline(const BaselineOptions& options, Progress& progress) {
  BeamConfig config = beam_config({.quick = true});
  config.fit_cells = 0;
  config.cells = options.quick ? std::vector<int>{3} : std::vector<int>{3, 6};
  const BeamTables tables = measure_beam(config, progress);
  Table rows({{"material"}, {"load"}, {"quantity"}, {"cells"}, {"value"}, {"status"}});
  for (std::size_t r = 0; r < tables.drops.size(); ++r)
    rows.add({tables.drops.text(r, "material"), tables.drops.text(r, "load"),
              fmt::format("drop of marker {:g}", tables.drops.number(r, "marker")),
              tables.drops.number(r, "cells"), tables.drops.number(r, "drop"),
              tables.drops.text(r, "status")});
  for (std::size_t r = 0; r < tables.ring_down.size(); ++r)
    for (const char* quantity : {"frequency", "damping_ratio", "swing_damping_ratio"})
      rows.add({tables.ring_down.text(r, "material"), tables.ring_down.text(r, "load"), std::string(quantity),
                tables.ring_down.number(r, "cells"), tables.ring_down.number(r, quantity),
                tables.ring_down.text(r, "status")});
  return rows;
}

}  // namespace

BeamConfig beam_config(const ExperimentOptions& options) {
  BeamConfig config{
      .materials = {{options.settings.empty() ? "as published"
                                              : fmt::format("{}", fmt::join(options.settings, ", "))}},
      .cells = options.quick ? std::vector<int>{3, 6} : std::vector<int>{3, 6, 12},
      .ringing_cells = options.quick ? std::vector<int>{3} : std::vector<int>{3, 6, 9},
      .ringing = beam_loads(),
      .settings = options.settings};
  if (!options.cells.empty()) config.cells = config.ringing_cells = options.cells;
  for (const int n : config.cells)
    if (n % 3 != 0)
      throw InputError(
          fmt::format("--cells has {}: the beam is 0.1 m long and 0.03 m wide, and its cells are "
                      "cubes; give multiples of 3",
                      n));
  std::sort(config.cells.begin(), config.cells.end());
  std::sort(config.ringing_cells.begin(), config.ringing_cells.end());
  if (options.settings.empty()) config.fit_cells = std::min(config.ringing_cells.back(), most_fit_cells);
  return config;
}

std::vector<NamedTable> beam_files(BeamTables tables) {
  return {{"beam", std::move(tables.drops)},
          {"beam_comsol", std::move(tables.comsol)},
          {"beam_ring_down", std::move(tables.ring_down)},
          {"beam_turns", std::move(tables.turns)},
          {"beam_motion", std::move(tables.motion)},
          {"beam_fits", std::move(tables.fits)}};
}

ExperimentInfo experiment() {
  return {.name = "beam",
          .under = "validate",
          .summary = "a silicone beam beside its measurement and COMSOL: drops, frequencies, ring-downs",
          .accepts = {.cells = true, .largest_cells = 24, .settings = true},
          .run = run_beam,
          .draw = draw_beam,
          .baseline = {.keys = {"material", "load", "quantity", "cells"},
                       .rules = {{"value", 1e-5}},
                       .table = beam_baseline}};
}

}  // namespace mss::studies::beam
