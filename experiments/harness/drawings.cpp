#include "experiments/harness/drawings.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/harness/other_work.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "experiments/plot/gnuplot.hpp"

namespace mss {

namespace fs = std::filesystem;

std::string notice_of(const Chart& chart, const Json& provenance) {
  const auto others = other_work_in(provenance);
  if (!chart.times || !others || others->share < disturbing_share) return chart.notice;
  const std::string beside =
      fmt::format("Measured beside other work ({:.0f} % of the cores).", 100 * others->share);
  return chart.notice.empty() ? beside : beside + " " + chart.notice;
}

std::vector<DrawnChart> write_drawings(Drawings drawings, const std::vector<NamedTable>& tables,
                                       const Json& provenance, const fs::path& directory) {
  const TemporaryDirectory scratch;
  std::vector<DrawnChart> drawn;
  const auto draw_one = [&](auto& named) {
    named.chart.footer = provenance_line(provenance);
    draw(named.chart, scratch.path() / named.name);
    drawn.push_back({named.name, named.chart.title, named.chart.subtitle,
                     named.table.empty() ? table_of(named.name, tables) : named.table});
  };
  for (NamedChart& chart : drawings.charts) {
    if (!has_points(chart.chart)) continue;
    chart.chart.notice = notice_of(chart.chart, provenance);
    draw_one(chart);
    drawn.back().notice = chart.chart.notice;
  }
  for (NamedMap& map : drawings.maps)
    if (has_cells(map.chart)) draw_one(map);
  for (const fs::path& file : files_of(drawn, ""))
    write_atomically(directory / file, read_file(scratch.path() / file));
  const auto is_main = [&](const DrawnChart& chart) { return chart.name == tables.front().name; };
  if (!tables.empty()) std::stable_partition(drawn.begin(), drawn.end(), is_main);
  return drawn;
}

std::vector<fs::path> files_of(const std::vector<DrawnChart>& charts, const fs::path& directory) {
  std::vector<fs::path> files;
  for (const DrawnChart& chart : charts)
    for (const char* format : {".svg", ".png"}) files.push_back(directory / (chart.name + format));
  return files;
}

}  // namespace mss
