// What charts of all kinds say to gnuplot.
#include "experiments/plot/gnuplot.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <vector>

#include "core/error.hpp"
#include "experiments/io/output.hpp"
#include "experiments/io/process.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

std::string range_end(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "*"; }

/// Ticks as gnuplot takes them: numbers, or names beside theirs.
std::string ticks_of(const ChartAxis& axis) {
  std::vector<std::string> ticks;
  for (std::size_t i = 0; i < axis.ticks.size(); ++i)
    ticks.push_back((i < axis.names.size() ? gnuplot_text(axis.names[i]) + " " : "") +
                    fmt::format("{}", axis.ticks[i]));
  return fmt::format("{}", fmt::join(ticks, ", "));
}

/// A directory of our own that disappears with everything in it.
struct ScratchDirectory {
  ScratchDirectory() {
    std::string name = (fs::temp_directory_path() / "mss-chart-XXXXXX").string();
    if (!mkdtemp(name.data())) throw InputError(fmt::format("no directory can be made as {}", name));
    path = name;
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  ~ScratchDirectory() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  fs::path path;
};

/// Machines without DejaVu fall back to fonts of the same widths, not to a serif one.
std::string with_fallback_fonts(std::string svg) {
  const std::string plain = fmt::format("font-family=\"{}\"", chart_font);
  const std::string fallback = fmt::format("font-family=\"{}, Verdana, sans-serif\"", chart_font);
  for (std::size_t at = 0; (at = svg.find(plain, at)) != std::string::npos; at += fallback.size())
    svg.replace(at, plain.size(), fallback);
  return svg;
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
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

void draw_with_gnuplot(
    const std::function<std::string(const std::string& svg, const std::string& png)>& script,
    const fs::path& stem) {
  const ScratchDirectory scratch;
  const fs::path program = scratch.path / "chart.gp", svg = scratch.path / "chart.svg",
                 png = scratch.path / "chart.png";
  write_atomically(program, script(svg.string(), png.string()));
  const ProgramRun run = run_program({"gnuplot", program.string()});
  const std::string target = stem.string() + ".svg";
  if (!run.started)
    throw InputError(fmt::format(
        "{} cannot be drawn because gnuplot is not installed; its package is gnuplot-nox", target));
  if (run.exit_status != 0 || !fs::exists(svg) || !fs::exists(png))
    throw InputError(
        fmt::format("{} cannot be drawn because gnuplot failed: {}", target, one_line(run.output)));
  write_atomically(target, with_fallback_fonts(read_file(svg)));
  write_atomically(stem.string() + ".png", read_file(png));
}

std::string gnuplot_version() {
  std::istringstream words(run_program({"gnuplot", "--version"}).output);  // "gnuplot 5.4 patchlevel 4"
  std::string name, version, word, patch;
  words >> name >> version >> word >> patch;
  if (name != "gnuplot") return {};
  return word == "patchlevel" ? fmt::format("{}.{}", version, patch) : version;
}

}  // namespace mss
