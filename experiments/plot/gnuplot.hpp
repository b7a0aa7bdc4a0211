#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "experiments/plot/chart.hpp"

namespace mss {

inline constexpr const char* chart_font = "DejaVu Sans";

/// A gnuplot string expression for text of another size than the rest.
std::string scaled_text(std::string_view text, double scale, bool bold = false);

/// A quoted file name: unlike shown text it has no markup to escape.
std::string file_name(const std::string& file);

/// Label, range, scale and ticks of the axis 'x' or 'y'.
std::string axis_commands(char name, const ChartAxis& axis);

/// Runs the program that `script` makes for two file names, and moves what it draws to STEM.svg and STEM.png.
/// Throws InputError if gnuplot is missing or refuses.
void draw_with_gnuplot(
    const std::function<std::string(const std::string& svg, const std::string& png)>& script,
    const std::filesystem::path& stem);

}  // namespace mss
