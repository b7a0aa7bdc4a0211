#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"
#include "experiments/harness/json.hpp"

namespace mss {

/// A chart that was drawn: NAME.svg and NAME.png.
struct DrawnChart {
  std::string name;
  std::string title;
  std::string subtitle;     ///< what is held fixed, what the bars show
  std::string table;        ///< most of what it shows; empty if that is not known
  std::string notice = {};  ///< what must be known before anything is read off it; empty if nothing
};

/// Draws every chart and map that has something on it to NAME.svg and NAME.png in a directory, all or none of
/// them, with the provenance of the run at their foot. Returns them, the one with the name of the first table
/// first. Throws InputError if gnuplot is missing or fails.
std::vector<DrawnChart> write_drawings(Drawings drawings, const std::vector<NamedTable>& tables,
                                       const Json& provenance, const std::filesystem::path& directory);

/// The notice of a chart of times: that it was measured beside other work, if the provenance says so, and
/// what the chart says itself.
std::string notice_of(const Chart& chart, const Json& provenance);

/// The files of charts in a directory.
std::vector<std::filesystem::path> files_of(const std::vector<DrawnChart>& charts,
                                            const std::filesystem::path& directory);

}  // namespace mss
