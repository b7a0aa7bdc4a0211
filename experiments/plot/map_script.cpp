// The gnuplot program of maps side by side.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/plot/gnuplot.hpp"
#include "experiments/plot/gnuplot_commands.hpp"

namespace mss {

namespace {

/// From light to dark, one of them hatched, then three that are hatched in grey. Text is white on the dark
/// one.
constexpr std::array<const char*, 8> fills{
    "fc '#e4eef7' fs solid 1 border lc '#e4eef7'",   "fc '#f0b75b' fs solid 1 border lc '#f0b75b'",
    "fc '#c0392b' fs pattern 1 border lc '#c0392b'", "fc '#5f93c0' fs solid 1 border lc '#5f93c0'",
    "fc '#8c1515' fs solid 1 border lc '#8c1515'",   "fc '#202020' fs pattern 2 border lc '#808080'",
    "fc '#202020' fs pattern 4 border lc '#808080'", "fc '#b0b0b0' fs pattern 5 border lc '#d0d0d0'"};

constexpr int dark_kind = 4;

constexpr double map_width = 1200, title_height = 100, foot_height = 105, panel_gap = 14;

/// Where panels go, in pixels.
struct Grid {
  explicit Grid(const MapChart& chart)
      : panels(int(chart.panels.size())),
        columns(chart.columns > 0 ? chart.columns
                : panels <= 2     ? 2
                : panels <= 6     ? 3
                                  : 4),
        height(chart.panel_height) {
    constexpr double letter = 9.5;
    std::size_t longest = 4;
    for (const std::string& name : chart.y.names) longest = std::max(longest, name.size());
    for (const MapPanel& panel : chart.panels)
      if (panel.title.find('\n') != std::string::npos) title = 48;
    left = (chart.y.label.empty() ? 40 : 85) + letter * double(longest);
    rows = (panels + columns - 1) / columns;
    pitch = height + title - 26;
  }
  double width() const { return (map_width - left - 25) / columns; }
  double page_height() const { return title_height + foot_height + 65 + rows * pitch; }
  double row_top(int row) const { return page_height() - title_height - row * pitch; }
  bool is_lowest(int panel) const { return panel + columns >= panels; }
  int panels, columns, rows = 0;
  double left = 0, height;  ///< of the first panel's left edge, and of every panel
  double title = 26;        ///< height of a panel's, of one line or two
  double pitch = 0;         ///< from row to row
};

std::string cell_data(const std::string& name, const MapPanel& panel, int kind) {
  std::string out = fmt::format("${} << END\n", name);
  for (const MapCell& c : panel.cells)
    if (c.kind == kind)
      out += fmt::format("{} {} {} {} {} {}\n", (c.x_low + c.x_high) / 2, (c.y_low + c.y_high) / 2, c.x_low,
                         c.x_high, c.y_low, c.y_high);
  return out + "END\n";
}

/// What cells say, those of the dark kind or the others, in their middle as it is seen.
std::string text_data(const std::string& name, const MapChart& chart, const MapPanel& panel, bool dark) {
  const auto middle = [](const ChartAxis& axis, double low, double high) {
    return axis.logarithmic ? std::sqrt(low * high) : (low + high) / 2;
  };
  std::string out = fmt::format("${} << END\n", name);
  for (const MapCell& c : panel.cells)
    if (!c.text.empty() && (c.kind == dark_kind) == dark)
      out += fmt::format("{} {} \"{{/*0.8 {}}}\"\n", middle(panel.x.value_or(chart.x), c.x_low, c.x_high),
                         middle(chart.y, c.y_low, c.y_high), c.text);
  return out + "END\n";
}

std::string line_data(const std::string& name, const std::vector<ChartPoint>& points) {
  std::string out = fmt::format("${} << END\n", name);
  for (const ChartPoint& p : points)
    out += std::isfinite(p.x) && std::isfinite(p.y) ? fmt::format("{} {}\n", p.x, p.y) : "\n";
  return out + "END\n";
}

/// Data of a panel and, in `plots`, what to draw from them.
std::string panel_data(const MapChart& chart, int index, std::vector<std::string>& plots) {
  const MapPanel& panel = chart.panels[std::size_t(index)];
  std::string out;
  for (int kind = 0; kind < int(chart.kinds.size()); ++kind) {
    const std::string name = fmt::format("cells{}_{}", index, kind);
    out += cell_data(name, panel, kind);
    plots.push_back(
        fmt::format("${} using 1:2:3:4:5:6 with boxxyerror {} notitle", name, fills[std::size_t(kind)]));
  }
  if (!panel.line.empty()) {
    const std::string name = fmt::format("line{}", index);
    out += line_data(name, panel.line);
    plots.push_back(fmt::format("${} using 1:2 with lines lc 'white' lw 5 notitle", name));
    plots.push_back(fmt::format("${} using 1:2 with lines lc 'black' lw 2.2 notitle", name));
  }
  for (const bool dark : {false, true}) {
    const std::string name = fmt::format("text{}_{}", index, dark ? "dark" : "light");
    const std::string data = text_data(name, chart, panel, dark);
    if (data.find('"') == std::string::npos) continue;
    out += data;
    plots.push_back(
        fmt::format("${} using 1:2:3 with labels tc '{}' notitle", name, dark ? "white" : "black"));
  }
  return out;
}

bool is_used(const MapChart& chart, int kind) {
  for (const MapPanel& panel : chart.panels)
    for (const MapCell& cell : panel.cells)
      if (cell.kind == kind) return true;
  return false;
}

/// What the legend shows: a name, and what fills or crosses its box.
struct LegendEntry {
  std::string label;
  std::string fill;  ///< empty: a line
};

std::vector<LegendEntry> legend_of(const MapChart& chart) {
  std::vector<LegendEntry> entries;
  for (std::size_t kind = 0; kind < chart.kinds.size(); ++kind)
    if (is_used(chart, int(kind))) entries.push_back({chart.kinds[kind], fills[kind]});
  if (!chart.blank_label.empty())
    entries.push_back({chart.blank_label, "fc 'white' fs solid 1 border lc '#808080'"});
  if (!chart.line_label.empty()) entries.push_back({chart.line_label, ""});
  return entries;
}

/// In as many rows as it needs, the last of them above the foot.
std::string legend_commands(const MapChart& chart, const Grid& grid) {
  constexpr double box_width = 34, box_height = 18, space = 12, letter = 8.6, from_foot = 52, pitch = 26,
                   left = 18;
  const double height = grid.page_height();
  const std::vector<LegendEntry> entries = legend_of(chart);
  std::vector<ChartPoint> places;  // in the first row, which is moved up by those that follow
  double x = left, down = 0;
  for (const LegendEntry& entry : entries) {
    const double width = box_width + 2 * space + letter * double(entry.label.size());
    if (x > left && x + width > map_width) x = left, down += pitch;
    places.push_back({x, -down});
    x += width;
  }
  std::string out;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const double y = places[i].y + down + from_foot;
    const auto corner = [&](double right, double up) {
      return fmt::format("screen {}, screen {}", (places[i].x + right) / map_width, (y + up) / height);
    };
    if (entries[i].fill.empty())
      out += fmt::format("set arrow from {} to {} nohead lc 'black' lw 2.2\n", corner(0, 0),
                         corner(box_width, 0));
    else
      out += fmt::format("set object rectangle from {} to {} {}\n", corner(0, -box_height / 2),
                         corner(box_width, box_height / 2), entries[i].fill);
    out += fmt::format("set label {} at {} left front\n", scaled_text(entries[i].label, 0.85),
                       corner(box_width + space / 2, 0));
  }
  return out;
}

/// Title, subtitle, foot and legend, drawn as an empty plot behind the panels.
std::string page_commands(const MapChart& chart, const Grid& grid) {
  const auto text = [&](const std::string& shown, double pixels, const char* colour) {
    return fmt::format("set label {} at screen 0.015, screen {} left tc '{}'\n", shown,
                       pixels / grid.page_height(), colour);
  };
  return "unset border\nunset tics\nunset xlabel\nunset ylabel\nunset title\n" +
         text(scaled_text(chart.title, 1.3, true), grid.page_height() - 30, "#000000") +
         text(scaled_text(chart.subtitle, 0.9), grid.page_height() - 66, "#404040") +
         text(scaled_text(chart.footer, 0.7), 20, "#606060") + legend_commands(chart, grid) +
         "set xrange [0:1]\nset yrange [0:1]\nplot NaN notitle\nunset label\nunset object\nunset arrow\n";
}

std::string panel_commands(const MapChart& chart, const Grid& grid, int index,
                           const std::vector<std::string>& plots) {
  const int row = index / grid.columns, column = index % grid.columns;
  const double left = grid.left + column * grid.width(), top = grid.row_top(row) - grid.title;
  const std::optional<ChartAxis>& own_x = chart.panels[std::size_t(index)].x;
  ChartAxis x = own_x.value_or(chart.x), y = chart.y;
  if (!own_x && !grid.is_lowest(index)) {
    x.label = "";
    x.names.assign(x.names.size(), "");
  }
  if (column > 0 || (grid.rows > 1 && row != (grid.rows - 1) / 2)) y.label = "";
  if (column > 0) y.names.assign(y.names.size(), "");
  const double foot = own_x ? 84 : 44;  // below a panel
  std::string out = fmt::format(
      "set lmargin at screen {}\nset rmargin at screen {}\nset tmargin at screen {}\nset bmargin at screen "
      "{}\n",
      left / map_width, (left + grid.width() - panel_gap) / map_width, top / grid.page_height(),
      (top - grid.height + foot) / grid.page_height());
  out += "set border 3 lc '#404040'\nset tics nomirror out tc '#202020'\nunset logscale\n";
  out += axis_commands('x', x) + axis_commands('y', y) + "set xtics nomirror out\nset ytics nomirror out\n";
  if (!own_x && !grid.is_lowest(index)) out += "set format x ''\n";
  if (column > 0) out += "set format y ''\n";
  out += fmt::format("set title {} offset 0, -0.6\n",
                     scaled_text(chart.panels[std::size_t(index)].title, 0.95, true));
  return out + fmt::format("plot {}\n", fmt::join(plots, ", \\\n  "));
}

}  // namespace

std::string gnuplot_script(const MapChart& chart, const std::string& svg_file, const std::string& png_file) {
  const Grid grid(chart);
  std::string data = "set encoding utf8\n", pages;
  for (int panel = 0; panel < grid.panels; ++panel) {
    std::vector<std::string> plots;
    data += panel_data(chart, panel, plots);
    pages += panel_commands(chart, grid, panel, plots);
  }
  const auto draw_with = [&](const char* terminal, int font_size, const std::string& file) {
    return fmt::format("set terminal {} size {},{} enhanced font '{},{}' background 'white'\nset output {}\n",
                       terminal, map_width, grid.page_height(), chart_font, font_size, file_name(file)) +
           "set multiplot\n" + page_commands(chart, grid) + pages + "unset multiplot\nset output\nreset\n";
  };
  return data + draw_with("svg dynamic", 19, svg_file) + draw_with("pngcairo", 14, png_file);
}

}  // namespace mss
