#include "experiments/harness/case_rows.hpp"

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "experiments/harness/journal.hpp"

namespace mss {

Json rows_of(const Table& table) {
  Json rows = Json::array();
  for (const std::vector<Cell>& row : table.rows()) {
    Json& cells = rows.emplace_back(Json::array());
    for (const Cell& cell : row) std::visit([&](const auto& value) { cells.push_back(value); }, cell);
  }
  return rows;
}

void add_rows(const Json& rows, Table& table) {
  for (const Json& row : rows) {
    std::vector<Cell> cells;
    for (const Json& cell : row) {
      if (cell.is_string())
        cells.emplace_back(cell.get<std::string>());
      else if (cell.is_number_integer())
        cells.emplace_back(cell.get<std::int64_t>());
      else
        cells.emplace_back(number(cell));
    }
    table.add(std::move(cells));
  }
}

}  // namespace mss
