#pragma once

#include <string>
#include <vector>

namespace mss::reference {

/// The cells of a line of a table that the program carries; those in quotes may hold commas.
std::vector<std::string> csv_cells(const std::string& line);

/// The number in a cell, NaN of an empty one. Throws std::logic_error where it holds something else.
double csv_number(const std::string& cell);

}  // namespace mss::reference
