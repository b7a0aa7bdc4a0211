#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace mss::reference {

/// A row of calculix/tables.csv, which make_tables.py computes.
struct CalculixRow {
  std::string study;
  double poisson;
  std::string element;
  int cells;
  std::string quantity;
  std::string unit;
  double value;
};
const std::vector<CalculixRow>& calculix_rows();

/// What quadratic elements say on their finest mesh, and by what share the mesh before differs.
struct CalculixValue {
  double value;
  double change;
};

/// Throws std::out_of_range if the table has no two meshes of it.
CalculixValue calculix_value(std::string_view study, double poisson, std::string_view quantity);

}  // namespace mss::reference
