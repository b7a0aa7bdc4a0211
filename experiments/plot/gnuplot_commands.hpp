#pragma once

#include <string>
#include <string_view>

#include "experiments/plot/chart.hpp"

// gnuplot commands that charts of all kinds need.

namespace mss {

inline constexpr const char* chart_font = "DejaVu Sans";

/// Text as a gnuplot string expression that shows exactly these characters in enhanced mode.
std::string gnuplot_text(std::string_view text);

/// A gnuplot string expression for text of another size than the rest.
std::string scaled_text(std::string_view text, double scale, bool bold = false);

/// A quoted file name: unlike displayed text it has no markup to escape.
std::string file_name(const std::string& file);

/// Label, range, scale and ticks of the axis 'x' or 'y'.
std::string axis_commands(char name, const ChartAxis& axis);

}  // namespace mss
