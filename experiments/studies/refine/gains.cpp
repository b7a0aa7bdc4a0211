// What cells of several sizes save at equal errors.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "experiments/studies/refine/maps.hpp"

namespace mss::studies::refine {

namespace {

/// From each row on, the largest error: values that cross the truth by chance have small ones for a while.
std::vector<double> errors_from_here_on(const Table& rows) {
  std::vector<double> errors(rows.size());
  double largest = 0;
  for (std::size_t r = rows.size(); r-- > 0;) {
    largest = std::max(largest, rows.number(r, "error"));
    errors[r] = largest;
  }
  return errors;
}

/// What x a curve has where it falls below an error for good, by interpolation of the logarithms between its
/// points; NaN where it does not.
double at_error(const Table& rows, const std::string& column, double error) {
  const std::vector<double> errors = errors_from_here_on(rows);
  for (std::size_t r = 0; r + 1 < rows.size(); ++r) {
    if (!(errors[r] >= error && error > errors[r + 1])) continue;
    const double share = std::log(errors[r] / error) / std::log(errors[r] / errors[r + 1]);
    return std::exp((1 - share) * std::log(rows.number(r, column)) +
                    share * std::log(rows.number(r + 1, column)));
  }
  return no_value;
}

}  // namespace

Table gains_of(const Table& rows) {
  Table gains({{"problem"}, {"map"}, {"error"}, {"quantity"}, {"gain"}, {"status"}});
  constexpr std::array<double, 4> errors{0.1, 0.05, 0.02, 0.01};
  constexpr std::array<const char*, 4> quantities{"particles", "answer_seconds", "period_seconds",
                                                  "local_period_seconds"};
  for (const std::string& problem : rows.distinct("problem")) {
    const Table of_problem = rows.where("problem", problem);
    const Table uniform = of_problem.where("map", to_string(Map::uniform));
    for (const Map map : {Map::by_hand, Map::estimated, Map::for_time, Map::surface})
      for (const double error : errors)
        for (const char* quantity : quantities) {
          const double gain = at_error(uniform, quantity, error) /
                              at_error(of_problem.where("map", to_string(map)), quantity, error);
          gains.add({problem, to_string(map), error, std::string(quantity), gain,
                     std::string(std::isfinite(gain) ? "ok" : "error not passed")});
        }
  }
  return gains;
}

}  // namespace mss::studies::refine
