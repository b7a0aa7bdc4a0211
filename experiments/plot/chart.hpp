#pragma once

#include <limits>
#include <string>
#include <vector>

namespace mss {

/// A point of a series. `low` and `high` draw an error bar; NaN: none. A point whose x or y is not finite is
/// left out.
struct ChartPoint {
  double x;
  double y;
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

/// A line with markers. Series differ by colour, dash pattern and marker, so that they can be distinguished
/// in a grey print too.
struct ChartSeries {
  std::string label = {};  ///< as the legend shows it; empty: not in the legend
  std::vector<ChartPoint> points = {};
  int style = -1;      ///< index into the chart styles; -1: the series' place in the chart
  bool lines = true;   ///< false: black markers (crosses, then open shapes) without a line, for what failed
  bool joined = true;  ///< false: its markers alone
  bool marked = true;  ///< false: its line alone, as of curves that are densely sampled
};

/// A straight line across the chart with its name on it.
struct ReferenceLine {
  enum class Direction { horizontal, vertical };
  Direction direction;
  double at;
  std::string label;
  bool below = false;  ///< whether the label of a horizontal line stands below it, not above
};

/// A single black point, or a bar from point.low to point.high if y is NaN, with text beside it: above it to
/// its right, or below it to its left.
struct MarkedPoint {
  ChartPoint point;
  std::string label;
  bool left = false;
};

struct ChartAxis {
  std::string label;  ///< quantity and unit
  bool logarithmic = false;
  double low = std::numeric_limits<double>::quiet_NaN();  ///< NaN: from the data
  double high = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> ticks = {};       ///< empty: chosen by the scale
  std::vector<std::string> names = {};  ///< of the ticks, in place of their numbers
  std::string unit = {};                ///< not empty: ticks read "10 ms" and the like
};

/// An axis of rows from the top, a name each.
ChartAxis named_rows(const std::vector<std::string>& names);

/// A chart of lines over two axes. Text is plain: nothing in it is markup.
struct Chart {
  enum class Legend { below, top_left, top_right, bottom_left, bottom_right };

  std::string title;
  std::string subtitle;     ///< what is held fixed, what the bars show
  std::string footer = {};  ///< machine and commit
  std::string notice =
      {};              ///< what readers must know before they read anything off it; in red below the subtitle
  bool times = false;  ///< it shows measured times, which other work on the machine disturbs
  ChartAxis x;
  ChartAxis y;
  std::vector<ChartSeries> series = {};
  std::vector<ReferenceLine> lines = {};
  std::vector<MarkedPoint> marks = {};
  Legend legend = Legend::below;
  std::string legend_title = {};
};

/// Whether there is anything to draw; gnuplot fails on an empty chart.
bool has_points(const Chart& chart);

}  // namespace mss
