#include "reference/csv_cells.hpp"

#include <limits>
#include <stdexcept>

namespace mss::reference {

std::vector<std::string> csv_cells(const std::string& line) {
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

double csv_number(const std::string& cell) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::size_t read = 0;
  const double value = std::stod(cell, &read);
  if (read != cell.size()) throw std::invalid_argument(cell);
  return value;
}

}  // namespace mss::reference
