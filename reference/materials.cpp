#include "reference/materials.hpp"

#include <fmt/format.h>

#include <numbers>
#include <sstream>
#include <stdexcept>

#include "reference/csv_cells.hpp"

namespace mss::reference {

extern const char* const materials_table;  // generated from materials.csv

namespace {

constexpr std::size_t material_columns = 12;

PublishedMaterial material_of(const std::vector<std::string>& cells) {
  return {.name = cells[0],
          .kind = cells[1],
          .young = csv_number(cells[2]),
          .young_low = csv_number(cells[3]),
          .young_high = csv_number(cells[4]),
          .poisson = csv_number(cells[5]),
          .poisson_measured = cells[6] == "measured",
          .density = csv_number(cells[7]),
          .loss = csv_number(cells[8]),
          .loss_frequency = csv_number(cells[9]),
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
    const std::vector<std::string> cells = csv_cells(line);
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
