#pragma once

#include <filesystem>
#include <string>

#include "experiments/plot/chart.hpp"
#include "experiments/plot/map_chart.hpp"

// What draws charts.

namespace mss {

/// The gnuplot program that draws a chart to the files named.
std::string gnuplot_script(const Chart& chart, const std::string& svg_file, const std::string& png_file);
std::string gnuplot_script(const MapChart& chart, const std::string& svg_file, const std::string& png_file);

/// Draws STEM.svg and STEM.png. Throws InputError if gnuplot is missing or fails; nothing is written then.
void draw(const Chart& chart, const std::filesystem::path& stem);
void draw(const MapChart& chart, const std::filesystem::path& stem);

/// Version of the gnuplot that draws, as in "5.4.4"; empty if there is none.
std::string gnuplot_version();

}  // namespace mss
