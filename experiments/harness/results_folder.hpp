#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/harness/drawings.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/json.hpp"

namespace mss {

/// What a run left in its directory.
struct ResultsFolder {
  std::filesystem::path directory;
  std::string experiment;  ///< its name
  Json meta;               ///< meta.json
  Json provenance;         ///< its part
  std::vector<NamedTable> tables;
};

/// Rows and units of tables by their files' names, as meta.json has them; columns without a unit hold names,
/// counts or ratios.
Json describe_tables(const std::vector<NamedTable>& tables);

/// Whether a run left its results in a directory.
bool has_results(const std::filesystem::path& directory);

/// Reads meta.json and the tables it lists. Throws InputError that names the file if one is missing or
/// incomplete.
ResultsFolder read_results(const std::filesystem::path& directory);

/// Draws all charts of a folder again from its tables and the provenance in its meta.json, into the same
/// folder: all or none. Returns them. Throws InputError if the tables are not those that `draw`
/// needs, leave nothing to draw, or gnuplot fails.
std::vector<DrawnChart> redraw(const ResultsFolder& folder,
                               const std::function<Drawings(const std::vector<NamedTable>&)>& draw);

}  // namespace mss
