#include "reference/published_rates.hpp"

#include <sstream>

#include "reference/csv_cells.hpp"

namespace mss::reference {

extern const char* const published_rates_table;  // generated from published_rates.csv

namespace {

std::vector<PublishedRate> read_rates() {
  std::istringstream lines(published_rates_table);
  std::string line;
  std::getline(lines, line);  // the header
  std::vector<PublishedRate> rates;
  while (std::getline(lines, line)) {
    const std::vector<std::string> cells = csv_cells(line);
    rates.push_back({.program = cells.at(0),
                     .year = int(csv_number(cells.at(1))),
                     .rate = csv_number(cells.at(2)),
                     .counted = cells.at(3),
                     .hardware = cells.at(4),
                     .quoted = cells.at(5),
                     .source = cells.at(6)});
  }
  return rates;
}

}  // namespace

const std::vector<PublishedRate>& published_rates() {
  static const std::vector<PublishedRate> rates = read_rates();
  return rates;
}

}  // namespace mss::reference
