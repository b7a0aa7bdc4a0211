#include "reference/calculix/calculix.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace mss::reference {

extern const char* const calculix_tables;  // generated from tables.csv

namespace {

std::vector<CalculixRow> parse() {
  std::vector<CalculixRow> rows;
  std::istringstream stream(calculix_tables);
  std::string line;
  std::getline(stream, line);  // the header
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    const auto next = [&] {
      std::string cell;
      std::getline(cells, cell, ',');
      return cell;
    };
    CalculixRow row;
    row.study = next();
    row.poisson = std::stod(next());
    row.element = next();
    row.cells = std::stoi(next());
    row.quantity = next();
    row.unit = next();
    row.value = std::stod(next());
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

const std::vector<CalculixRow>& calculix_rows() {
  static const std::vector<CalculixRow> rows = parse();
  return rows;
}

CalculixValue calculix_value(std::string_view study, double poisson, std::string_view quantity) {
  const CalculixRow *before = nullptr, *finest = nullptr;
  for (const CalculixRow& row : calculix_rows()) {  // ascending by cells
    if (row.study != study || row.poisson != poisson || row.quantity != quantity || row.element != "C3D20")
      continue;
    before = finest;
    finest = &row;
  }
  if (before == nullptr) throw std::out_of_range("no CalculiX table of " + std::string(study));
  return {finest->value, std::abs(before->value / finest->value - 1)};
}

}  // namespace mss::reference
