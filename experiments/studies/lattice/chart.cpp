// Charts of `mss validate lattice`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/studies/lattice/lattice.hpp"

namespace mss::studies::lattice {

namespace {

Table of_material(const Table& rows, double poisson, double face_share) {
  return rows.where("poisson", poisson).where("face_share", face_share);
}

/// The material that the curves against wavelength are of: the default's, if it was measured.
LatticeMaterial charted(const Table& rows) {
  const LatticeMaterial usual{};
  return of_material(rows, usual.poisson, usual.face_share).size() > 0
             ? usual
             : LatticeMaterial{rows.number(0, "poisson"), rows.number(0, "face_share")};
}

Chart speed_chart(const Table& all) {
  const LatticeMaterial material = charted(all);
  const Table rows = of_material(all, material.poisson, material.face_share);
  Chart chart{.title = "Speed of waves in a lattice of springs",
              .subtitle = fmt::format("phase speed of plane waves, infinite lattice, {}; along [100] both "
                                      "are alike",
                                      material.name()),
              .x = {.label = "cells per wavelength",
                    .logarithmic = true,
                    .low = 2.8,
                    .high = 34,
                    .ticks = rows.distinct_numbers("cells_per_wavelength")},
              .y = {.label = "phase speed / the continuum's"}};
  for (const WaveKind kind : {WaveKind::longitudinal, WaveKind::slow_shear})
    for (const char* direction : {"[100]", "[110]", "[111]"}) {
      ChartSeries series{.label = fmt::format("{}, {}", to_string(kind), direction)};
      const Table of_wave = rows.where("wave", to_string(kind)).where("direction", direction);
      for (std::size_t r = 0; r < of_wave.size(); ++r)
        series.points.push_back(
            {of_wave.number(r, "cells_per_wavelength"), of_wave.number(r, "speed_over_continuum")});
      chart.series.push_back(std::move(series));
    }
  chart.lines.push_back({ReferenceLine::Direction::horizontal, 1, "continuum"});
  return chart;
}

constexpr double charted_cells = 8;  ///< per wavelength, where speeds are shown against the face share

/// The band of speeds over all directions, as slowest and fastest.
Chart share_chart(const Table& all) {
  const Table rows = all.where("cells_per_wavelength", charted_cells);
  Chart chart{.title = "Speed of waves against the share of face diagonals",
              .subtitle = fmt::format(
                  "{:g} cells a wavelength; bars: from the slowest to the fastest direction", charted_cells),
              .x = {.label = "face share, t",
                    .low = -0.05,
                    .high = 1.05,
                    .ticks = rows.distinct_numbers("face_share")},
              .y = {.label = "phase speed / the continuum's"}};
  int place = 0;
  for (const double poisson : rows.distinct_numbers("poisson"))
    for (const WaveKind kind : wave_kinds) {
      ChartSeries series{.label = fmt::format("{}, nu = {:g}", to_string(kind), poisson)};
      const Table of_kind = rows.where("poisson", poisson).where("wave", to_string(kind));
      const Table slowest = of_kind.where("direction", "slowest"),
                  fastest = of_kind.where("direction", "fastest");
      for (std::size_t r = 0; r < slowest.size(); ++r) {
        const double low = slowest.number(r, "speed_over_continuum"),
                     high = fastest.number(r, "speed_over_continuum");
        series.points.push_back(
            {slowest.number(r, "face_share") + 0.012 * (place - 2.5), (low + high) / 2, low, high});
      }
      ++place;
      chart.series.push_back(std::move(series));
    }
  return chart;
}

/// The smallest limit of one kind of path against Poisson's ratio, with a gap where there is none.
ChartSeries limit_series(const Table& all, StrainPath::Kind kind, double share) {
  ChartSeries series{.label = fmt::format("{}, t = {:g}", mss::to_string(kind), share)};
  for (const double poisson : all.distinct_numbers("poisson")) {
    const Table rows = of_material(all, poisson, share);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t r = 0; r < rows.size(); ++r)
      if (rows.text(r, "path").starts_with(mss::to_string(kind)) && std::isfinite(rows.number(r, "strain")))
        least = std::min(least, rows.number(r, "strain"));
    if (std::isfinite(least)) series.points.push_back({poisson, least});
  }
  return series;
}

/// In tension and shear shares differ little where Poisson's ratio is small, and have few limits elsewhere.
Chart limits_chart(const Table& all) {
  using Kind = StrainPath::Kind;
  Chart chart{.title = "Strains at which the lattice of springs becomes unstable",
              .subtitle =
                  "beyond, a wave grows or free sides give way; smallest of three directions; no point: "
                  "stable up to 0.9",
              .x = {.label = "Poisson's ratio"},
              .y = {.label = "strain", .low = 0, .high = 1}};
  std::vector<ChartSeries> series;
  for (const Kind kind : {Kind::tension, Kind::shear})
    series.push_back(limit_series(all, kind, LatticeMaterial{}.face_share));
  for (const double share : all.distinct_numbers("face_share"))
    series.push_back(limit_series(all, Kind::compression, share));
  for (ChartSeries& one : series)
    if (!one.points.empty()) chart.series.push_back(std::move(one));
  chart.lines.push_back({ReferenceLine::Direction::vertical, 0.25, "k_vol = 0"});
  return chart;
}

}  // namespace

Drawings draw_lattice(const std::vector<NamedTable>& tables) {
  const Table& speeds = find_table(tables, "lattice");
  const Table& limits = find_table(tables, "lattice_limits");
  Drawings drawings;
  if (speeds.size() > 0) {
    drawings.charts.push_back({"lattice", speed_chart(speeds)});
    if (speeds.where("cells_per_wavelength", charted_cells).size() > 0)
      drawings.charts.push_back({"lattice_share", share_chart(speeds), "lattice"});
  }
  if (limits.size() > 0) drawings.charts.push_back({"lattice_limits", limits_chart(limits)});
  return drawings;
}

}  // namespace mss::studies::lattice
