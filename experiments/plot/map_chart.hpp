#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/plot/chart.hpp"

namespace mss {

/// A rectangle of a map, of the kind that fills it.
struct MapCell {
  double x_low, x_high, y_low, y_high;
  int kind;            ///< index into MapChart::kinds
  std::string text{};  ///< in its middle: a number of few digits
};

/// One map among several over the same axes, or at least the same y.
struct MapPanel {
  std::string title;  ///< of one line or two
  std::vector<MapCell> cells = {};
  std::vector<ChartPoint> line = {};  ///< drawn over the cells
  std::optional<ChartAxis> x = {};    ///< in place of the chart's
};

/// Maps of kinds over two axes, side by side. Kinds differ in lightness or hatching, so that they can be
/// distinguished in a grey print too; at most eight.
struct MapChart {
  std::string title;
  std::string subtitle;
  std::string footer = {};
  ChartAxis x;
  ChartAxis y;
  std::vector<std::string> kinds;
  std::string line_label = {};   ///< of the panels' lines; empty: there are none
  std::string blank_label = {};  ///< what places without a cell mean; empty: nothing
  std::vector<MapPanel> panels = {};
  double panel_height = 240;  ///< [px]; widths share the page
  int columns = 0;            ///< panels in a row; 0: up to four, fewer where there are few
};

/// A number for a narrow place: without the zero before its point.
std::string short_number(double x);

/// Whether there is anything to draw.
bool has_cells(const MapChart& chart);

}  // namespace mss
