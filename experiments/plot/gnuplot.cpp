// Runs gnuplot.
#include "experiments/plot/gnuplot.hpp"

#include <fmt/format.h>

#include <sstream>

#include "core/base/error.hpp"
#include "experiments/io/output.hpp"
#include "experiments/io/process.hpp"
#include "experiments/plot/gnuplot_commands.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

/// Viewers without DejaVu then fall back to a font of the same widths instead of a serif one.
std::string with_fallback_fonts(std::string svg) {
  const std::string plain = fmt::format("font-family=\"{}\"", chart_font);
  const std::string fallback = fmt::format("font-family=\"{}, Verdana, sans-serif\"", chart_font);
  for (std::size_t at = 0; (at = svg.find(plain, at)) != std::string::npos; at += fallback.size())
    svg.replace(at, plain.size(), fallback);
  return svg;
}

template <class AnyChart>
void draw_with_gnuplot(const AnyChart& chart, const fs::path& stem) {
  const TemporaryDirectory scratch;
  const fs::path program = scratch.path() / "chart.gp", svg = scratch.path() / "chart.svg",
                 png = scratch.path() / "chart.png";
  write_atomically(program, gnuplot_script(chart, svg.string(), png.string()));
  const ProgramRun run = run_program({"gnuplot", program.string()});
  const std::string target = stem.filename().string() + ".svg";
  if (!run.started)
    throw InputError(fmt::format(
        "{} cannot be drawn because gnuplot is not installed; its package is gnuplot-nox", target));
  if (run.exit_status != 0 || !fs::exists(svg) || !fs::exists(png))
    throw InputError(fmt::format("{} cannot be drawn because gnuplot failed: {}", target, run.output));
  write_atomically(stem.string() + ".svg", with_fallback_fonts(read_file(svg)));
  write_atomically(stem.string() + ".png", read_file(png));
}

}  // namespace

void draw(const Chart& chart, const fs::path& stem) { draw_with_gnuplot(chart, stem); }
void draw(const MapChart& chart, const fs::path& stem) { draw_with_gnuplot(chart, stem); }

std::string gnuplot_version() {
  std::istringstream words(run_program({"gnuplot", "--version"}).output);  // "gnuplot 5.4 patchlevel 4"
  std::string name, version, word, patch;
  words >> name >> version >> word >> patch;
  if (name != "gnuplot") return {};
  return word == "patchlevel" ? fmt::format("{}.{}", version, patch) : version;
}

}  // namespace mss
