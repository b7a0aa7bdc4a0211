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

/// The limit of quadratic elements under refinement, extrapolated from the three finest meshes (value + c h^p
/// through all of them: where a fixed edge is singular p is near 1), and the relative difference of the
/// finest.
struct CalculixValue {
  double value;
  double uncertainty;
};

/// Throws std::out_of_range if the table has no three meshes of it that converge.
CalculixValue calculix_value(std::string_view study, double poisson, std::string_view quantity);

}  // namespace mss::reference
