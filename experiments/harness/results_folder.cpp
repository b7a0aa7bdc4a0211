#include "experiments/harness/results_folder.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "core/base/error.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

NamedTable read_table(const fs::path& file, std::size_t rows) {
  Table table = Table::read(read_file(file), file.string());
  if (table.size() != rows)
    throw InputError(fmt::format("{} has {} rows; its meta.json says {}", file.string(), table.size(), rows));
  return {file.stem().string(), std::move(table)};
}

}  // namespace

Json describe_tables(const std::vector<NamedTable>& tables) {
  Json json = Json::object();
  for (const NamedTable& named : tables) {
    Json units = Json::object();
    for (const Column& column : named.table.columns())
      if (!column.unit.empty()) units[column.name] = column.unit;
    json[named.name + ".csv"] = {{"rows", named.table.size()}, {"units", units}};
  }
  return json;
}

bool has_results(const fs::path& directory) { return fs::exists(directory / "meta.json"); }

ResultsFolder read_results(const fs::path& directory) {
  if (!fs::is_directory(directory))
    throw InputError(fmt::format("{} is not a directory", directory.string()));
  const fs::path file = directory / "meta.json";
  if (!fs::exists(file))
    throw InputError(
        fmt::format("{} has no meta.json; give a directory that an experiment wrote", directory.string()));
  try {
    const Json meta = Json::parse(read_file(file));
    ResultsFolder folder{
        directory, meta.at("experiment").get<std::string>(), meta, meta.at("provenance"), {}};
    for (const auto& [name, about] : meta.at("tables").items())
      folder.tables.push_back(read_table(directory / name, about.at("rows").get<std::size_t>()));
    return folder;
  } catch (const Json::exception& problem) {
    throw InputError(fmt::format("{} is not the record of an experiment: {}", file.string(), problem.what()));
  }
}

std::vector<DrawnChart> redraw(const ResultsFolder& folder,
                               const std::function<Drawings(const std::vector<NamedTable>&)>& draw) {
  try {
    std::vector<DrawnChart> charts =
        write_drawings(draw(folder.tables), folder.tables, folder.provenance, folder.directory);
    if (charts.empty()) throw InputError("there are too few rows for a chart");
    return charts;
  } catch (const std::logic_error& problem) {  // a column that is missing, or of text instead of numbers
    throw InputError(problem.what());
  } catch (const Json::exception& problem) {
    throw InputError(problem.what());
  }
}

}  // namespace mss
