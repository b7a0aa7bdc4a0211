#include "experiments/plot/gnuplot_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <vector>

namespace mss {

namespace {

std::string range_end(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "*"; }

/// Ticks as gnuplot takes them: numbers, or names beside theirs.
std::string ticks_of(const ChartAxis& axis) {
  std::vector<std::string> ticks;
  for (std::size_t i = 0; i < axis.ticks.size(); ++i)
    ticks.push_back((i < axis.names.size() ? gnuplot_text(axis.names[i]) + " " : "") +
                    fmt::format("{}", axis.ticks[i]));
  return fmt::format("{}", fmt::join(ticks, ", "));
}

}  // namespace

std::string gnuplot_text(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\n') {
      out += "'.\"\\n\".'";
      continue;
    }
    if (std::string_view("{}^_@&~\\").find(c) != std::string_view::npos) out += '\\';
    if (c == '\'') out += '\'';
    out += c;
  }
  return out + "'";
}

std::string scaled_text(std::string_view text, double scale, bool bold) {
  return fmt::format("'{{/{}*{} '.{}.'}}'", bold ? ":Bold" : "", scale, gnuplot_text(text));
}

std::string file_name(const std::string& file) {
  std::string out = "'";
  for (const char c : file) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

std::string axis_commands(char name, const ChartAxis& axis) {
  std::string out = fmt::format("set {}label {}\n", name, gnuplot_text(axis.label));
  out += fmt::format("set {}range [{}:{}]\n", name, range_end(axis.low), range_end(axis.high));
  if (axis.logarithmic) out += fmt::format("set logscale {} 10\n", name);
  if (!axis.unit.empty())
    out += fmt::format("set format {} '%.0s %c'.{}\n", name, gnuplot_text(axis.unit));
  else
    out +=
        fmt::format("set format {} '{}'\n", name, axis.logarithmic && axis.ticks.empty() ? "10^{%L}" : "%g");
  if (!axis.ticks.empty())
    out += fmt::format("set {}tics ({})\n", name, ticks_of(axis));
  else if (axis.logarithmic)
    out += fmt::format("set {0}tics 10\nset m{0}tics 10\n", name);
  return out;
}

}  // namespace mss
