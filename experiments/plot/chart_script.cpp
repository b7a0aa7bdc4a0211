// The gnuplot program of a chart of lines.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/plot/gnuplot.hpp"
#include "experiments/plot/gnuplot_commands.hpp"

namespace mss {

namespace {

/// No two have the same dash and marker, nor the same marker and colours that are equally dark, so that
/// markers alone are told apart in grey. There are no fewer than integrators, whose places in their list
/// choose them.
struct LineStyle {
  const char* colour;
  const char* dash;
  int marker;
};
constexpr std::array<LineStyle, 28> line_styles{
    {{"#a50f15", "1", 7},           {"#ef6548", "(10,4)", 6},      {"#e08214", "(10,3,2,3)", 5},
     {"#6e6e6e", "(2,3)", 8},       {"#08519c", "1", 9},           {"#4292c6", "(10,4)", 10},
     {"#006d2c", "1", 13},          {"#41ab5d", "(10,4)", 12},     {"#54278f", "(10,3,2,3)", 11},
     {"#807dba", "(2,3)", 4},       {"#a6761d", "1", 15},          {"#d9a441", "(10,4)", 14},
     {"#c51b7d", "1", 5},           {"#e78ac3", "(10,4)", 4},      {"#1b7f79", "(10,3,2,3)", 7},
     {"#252525", "(2,3)", 6},       {"#c994c7", "(10,4)", 7},      {"#35978f", "(2,3)", 9},
     {"#c7a76c", "(10,3,2,3)", 13}, {"#9ecae1", "(10,3,2,3)", 15}, {"#08306b", "1", 10},
     {"#bf812d", "(2,3)", 11},      {"#00441b", "(2,3)", 12},      {"#67000d", "1", 14},
     {"#3f007d", "(10,4)", 8},      {"#b2abd2", "(10,3,2,3)", 8},  {"#bdbdbd", "(2,3)", 10},
     {"#d9b8e0", "1", 12}}};

/// Of failed runs, in black: crosses and open shapes.
constexpr std::array<int, 6> failure_markers{2, 1, 3, 8, 12, 6};

constexpr double page_width = 1200, page_height = 900;  ///< [px]

std::string line_commands(const ReferenceLine& line) {
  const bool flat = line.direction == ReferenceLine::Direction::horizontal;
  const auto place = [&](const char* along) {
    return flat ? fmt::format("graph {}, first {}", along, line.at)
                : fmt::format("first {}, graph {}", line.at, along);
  };
  return fmt::format("set arrow from {} to {} nohead back lw 1.5 dt (6,3) lc '#404040'\n", place("0"),
                     place("1")) +
         fmt::format("set label {} at {} {} tc '#404040' front\n", scaled_text(line.label, 0.8),
                     place(flat ? "0.01" : "0.98"),
                     flat ? fmt::format("left offset 0, {}", line.below ? -0.55 : 0.55)
                          : "right rotate by 90 offset -0.7, 0");
}

bool is_drawn(const ChartPoint& p) { return std::isfinite(p.x) && std::isfinite(p.y); }
bool has_bar(const ChartPoint& p) { return std::isfinite(p.low) && std::isfinite(p.high); }

/// A block of lines "x y" or, if `bars`, "x y low high" of the points that have a bar. Gaps are left out.
std::string data_block(const std::string& name, const std::vector<ChartPoint>& points, bool bars) {
  std::string out = fmt::format("${} << END\n", name);
  for (const ChartPoint& p : points) {
    if (!is_drawn(p)) continue;
    if (!bars)
      out += fmt::format("{} {}\n", p.x, p.y);
    else if (has_bar(p))
      out += fmt::format("{} {} {} {}\n", p.x, p.y, p.low, p.high);
  }
  return out + "END\n";
}

/// The data blocks and, in `plots`, what to draw from them. Bars are solid whatever the line's dashes.
std::string series_commands(const Chart& chart, std::vector<std::string>& plots) {
  std::string out;
  std::size_t failures = 0;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const ChartSeries& series = chart.series[i];
    const LineStyle& style =
        line_styles[(series.style < 0 ? i : std::size_t(series.style)) % line_styles.size()];
    if (std::any_of(series.points.begin(), series.points.end(), has_bar)) {
      out += data_block(fmt::format("bars{}", i), series.points, true);
      plots.push_back(
          fmt::format("$bars{} using 1:2:3:4 with yerrorbars lc '{}' lw 1.2 pt 0 notitle", i, style.colour));
    }
    out += data_block(fmt::format("series{}", i), series.points, false);
    // gnuplot would leave a series without points out of the legend, whose label may say why it has none.
    const bool any = std::any_of(series.points.begin(), series.points.end(), is_drawn);
    const std::string data = any ? fmt::format("$series{} using 1:2", i) : "NaN";
    if (!series.lines) {
      plots.push_back(fmt::format("{} with points lc 'black' lw 2 pt {} ps 1.4*unit title {}", data,
                                  failure_markers[failures++ % failure_markers.size()],
                                  gnuplot_text(series.label)));
      continue;
    }
    if (!series.marked) {
      plots.push_back(fmt::format("{} with lines lc '{}' lw 2.2 dt {} title {}", data, style.colour,
                                  style.dash, gnuplot_text(series.label)));
      continue;
    }
    const std::string look = series.joined
                                 ? fmt::format("linespoints lc '{}' lw 2.2 dt {}", style.colour, style.dash)
                                 : fmt::format("points lc '{}' lw 1.6", style.colour);
    plots.push_back(fmt::format("{} with {} pt {} ps 1.1*unit title {}", data, look, style.marker,
                                gnuplot_text(series.label)));
  }
  return out;
}

/// Marked points and bars, black, with their text.
std::string mark_commands(const Chart& chart, std::vector<std::string>& plots) {
  std::vector<ChartPoint> points;
  std::string out;
  for (const MarkedPoint& mark : chart.marks) {
    const ChartPoint& p = mark.point;
    const bool bar = !std::isfinite(p.y);
    const double middle = bar ? std::sqrt(p.low * p.high) : p.y;
    if (bar)
      out += fmt::format(
          "set arrow from first {0}, first {1} to first {0}, first {2} heads size screen 0.006,90 lw 3 "
          "front\n",
          p.x, p.low, p.high);
    else
      points.push_back(p);
    const double across = mark.left ? -1.1 : 1.1, up = bar ? 0 : (mark.left ? -0.75 : 0.75);
    out += fmt::format("set label {} at first {}, first {} {} offset {}, {} front\n",
                       scaled_text(mark.label, 0.8), p.x, middle, mark.left ? "right" : "left", across, up);
  }
  if (!points.empty())
    plots.emplace_back("$marks using 1:2 with points lc 'black' lw 2.5 pt 3 ps 2*unit notitle");
  return out + data_block("marks", points, false);
}

const char* legend_place(Chart::Legend legend) {
  switch (legend) {
    case Chart::Legend::below:
      break;
    case Chart::Legend::top_left:
      return "inside top left";
    case Chart::Legend::top_right:
      return "inside top right";
    case Chart::Legend::bottom_left:
      return "inside bottom left";
    case Chart::Legend::bottom_right:
      return "inside bottom right";
  }
  return "";
}

struct LegendGrid {
  std::size_t columns, rows;
  std::size_t longest;  ///< letters of a label
};

/// As many columns, filled one after the other, as the labels leave room for.
LegendGrid legend_grid(const Chart& chart) {
  constexpr std::size_t short_label = 20;
  constexpr double column_letter = 13.3, letter = 12,
                   width = 1100;  // [px] of a column's, of the last label's
  std::vector<std::size_t> lengths;
  for (const ChartSeries& series : chart.series)
    if (!series.label.empty()) lengths.push_back(series.label.size());
  if (lengths.empty()) return {1, 0, 0};
  const std::size_t longest = *std::max_element(lengths.begin(), lengths.end());
  const auto rows_in = [&](std::size_t columns) { return (lengths.size() + columns - 1) / columns; };
  if (longest <= short_label) return {3, rows_in(3), longest};
  const auto right = lengths.begin() + std::ptrdiff_t(rows_in(2));
  const std::size_t longest_right = right == lengths.end() ? 0 : *std::max_element(right, lengths.end());
  const bool fit = column_letter * double(longest) + letter * double(longest_right) <= width;
  return fit ? LegendGrid{2, rows_in(2), longest} : LegendGrid{1, lengths.size(), longest};
}

/// Margins, legend, title and foot; heights in pixels from below.
std::string layout_commands(const Chart& chart) {
  constexpr double legend_row = 30;
  const auto screen = [](double pixels) { return pixels / page_height; };
  const bool below = chart.legend == Chart::Legend::below;
  const auto [columns, rows, longest] = legend_grid(chart);
  const double legend = below ? legend_row * double(rows + (chart.legend_title.empty() ? 0 : 1)) : 0;
  constexpr double right = 0.965;  // half of a tick's label stands beyond the last tick
  const double notice = chart.notice.empty() ? 0 : 32;
  std::string out =
      fmt::format("set tmargin at screen {}\nset bmargin at screen {}\nset rmargin at screen {}\n",
                  screen(page_height - 105 - notice), screen(129 + legend), right);
  out += fmt::format("set key {} Left reverse samplen 3\n", legend_place(chart.legend));
  if (below) {
    // gnuplot reserves a fifth more width than the letters of this font take, in units of a wide letter.
    out += fmt::format("set key at screen 0.015, screen {} left top vertical maxrows {} width {}\n",
                       screen(54 + legend), rows, columns == 2 ? -0.15 * double(longest) : 0.0);
  }
  if (!chart.legend_title.empty())
    out += fmt::format("set key title {} left\n", scaled_text(chart.legend_title, 0.9));
  const auto page_text = [&](const std::string& text, double height, const char* colour) {
    out +=
        fmt::format("set label {} at screen 0.015, screen {} left tc '{}'\n", text, screen(height), colour);
  };
  page_text(scaled_text(chart.title, 1.3, true), page_height - 32, "#000000");
  page_text(scaled_text(chart.subtitle, 0.9), page_height - 70, "#404040");
  if (!chart.notice.empty()) page_text(scaled_text(chart.notice, 0.9), page_height - 102, "#a50f15");
  page_text(scaled_text(chart.footer, 0.7), 22, "#606060");
  return out;
}

}  // namespace

std::string gnuplot_script(const Chart& chart, const std::string& svg_file, const std::string& png_file) {
  std::string out = "set encoding utf8\nset micro\n";
  std::vector<std::string> plots;
  out += series_commands(chart, plots) + mark_commands(chart, plots);
  for (const ReferenceLine& line : chart.lines) out += line_commands(line);
  out += axis_commands('x', chart.x) + axis_commands('y', chart.y);
  out +=
      "set grid xtics ytics lt 1 lc rgb '#d4d4d4' lw 1\nset border 3 lc '#404040'\nset tics nomirror tc "
      "'#202020'\n";
  out += "set errorbars small\n";
  out += layout_commands(chart);
  // gnuplot's SVG counts fonts in pixels, not points, draws markers larger and sets lines further apart.
  const auto draw_with = [&](const char* terminal, int font_size, double unit, double spacing,
                             double label_lift, const std::string& file) {
    out += fmt::format("set terminal {} size {},{} enhanced font '{},{}' background 'white'\n", terminal,
                       page_width, page_height, chart_font, font_size);
    out += fmt::format("unit = {}\nset key spacing {}\nset xlabel offset 0, {}\n", unit, spacing, label_lift);
    out += fmt::format("set output {}\nplot {}\nset output\n", file_name(file), fmt::join(plots, ", \\\n  "));
  };
  draw_with("svg dynamic", 21, 0.7, 0.94, 0.5, svg_file);
  draw_with("pngcairo", 16, 1, 1.2, 0, png_file);
  return out;
}

}  // namespace mss
