#include "reference/calculix/calculix.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

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
  std::vector<const CalculixRow*> rows;  // ascending by cells
  for (const CalculixRow& row : calculix_rows())
    if (row.study == study && row.poisson == poisson && row.quantity == quantity && row.element == "C3D20")
      rows.push_back(&row);
  if (rows.size() < 3) throw std::out_of_range("no three CalculiX meshes of " + std::string(study));
  const CalculixRow &a = *rows[rows.size() - 3], &b = *rows[rows.size() - 2], &c = *rows[rows.size() - 1];
  const double ratio = (a.value - b.value) / (b.value - c.value);
  const auto steps = [&](double p) {  // the same ratio if the error is a power of the size
    const double ha = std::pow(a.cells, -p), hb = std::pow(b.cells, -p), hc = std::pow(c.cells, -p);
    return std::pair((ha - hb) / (hb - hc), hc / (hb - hc));
  };
  double low = 0.1, high = 10;  // the ratio grows with p
  if (!(steps(low).first < ratio && ratio < steps(high).first))
    throw std::out_of_range("CalculiX's meshes of " + std::string(study) + " do not converge");
  for (int i = 0; i < 100; ++i) (steps((low + high) / 2).first < ratio ? low : high) = (low + high) / 2;
  const double value = c.value - (b.value - c.value) * steps(low).second;
  return {value, std::abs(c.value / value - 1)};
}

}  // namespace mss::reference
