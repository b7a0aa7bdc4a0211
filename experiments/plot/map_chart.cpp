#include "experiments/plot/map_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace mss {

std::string short_number(double x) {
  std::string text = fmt::format("{:g}", x);
  if (const double power = std::round(std::log10(std::abs(x))); power >= 3 && std::pow(10, power) == x)
    return fmt::format("1e{:.0f}", power);
  if (const std::size_t zero = text.find("0."); zero == 0 || (zero == 1 && text[0] == '-'))
    text.erase(zero, 1);
  return text;
}

bool has_cells(const MapChart& chart) {
  return std::any_of(chart.panels.begin(), chart.panels.end(),
                     [](const MapPanel& panel) { return !panel.cells.empty(); });
}

}  // namespace mss
