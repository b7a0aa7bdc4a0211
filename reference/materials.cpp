#include "reference/materials.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace mss::reference {

extern const char* const materials_table;  // generated from materials.csv

namespace {

constexpr std::size_t material_columns = 12;

/// The cells of a line; those in quotes may hold commas.
std::vector<std::string> material_cells(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  return cells;
}

/// NaN of an empty cell.
double material_number(const std::string& cell) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::size_t read = 0;
  const double value = std::stod(cell, &read);
  if (read != cell.size()) throw std::invalid_argument(cell);
  return value;
}

PublishedMaterial material_of(const std::vector<std::string>& cells) {
  return {.name = cells[0],
          .kind = cells[1],
          .young = material_number(cells[2]),
          .young_low = material_number(cells[3]),
          .young_high = material_number(cells[4]),
          .poisson = material_number(cells[5]),
          .poisson_measured = cells[6] == "measured",
          .density = material_number(cells[7]),
          .loss = material_number(cells[8]),
          .loss_frequency = material_number(cells[9]),
          .measured = cells[10],
          .source = cells[11]};
}

}  // namespace

double PublishedMaterial::viscosity() const {
  return loss * shear_modulus() / (2 * std::numbers::pi * loss_frequency);
}

std::vector<PublishedMaterial> read_materials(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);  // the header
  std::vector<PublishedMaterial> materials;
  for (int number = 2; std::getline(lines, line); ++number) {
    const std::vector<std::string> cells = material_cells(line);
    if (cells.size() != material_columns)
      throw std::invalid_argument(
          fmt::format("materials.csv:{} has {} cells, not {}", number, cells.size(), material_columns));
    try {
      materials.push_back(material_of(cells));
    } catch (const std::logic_error&) {  // what std::stod throws
      throw std::invalid_argument(fmt::format("materials.csv:{} has text where a number belongs", number));
    }
  }
  return materials;
}

const std::vector<PublishedMaterial>& published_materials() {
  static const std::vector<PublishedMaterial> materials = read_materials(materials_table);
  return materials;
}

}  // namespace mss::reference
