// What cells of several sizes save at equal errors.
#include <array>
#include <cmath>

#include "experiments/studies/refine/maps.hpp"

namespace mss::studies::refine {

namespace {

/// What x a curve has at an error, by interpolation of the logarithms between its points of falling error;
/// NaN where it has none.
double at_error(const Table& rows, const std::string& column, double error) {
  double least = no_value;
  for (std::size_t r = 0; r + 1 < rows.size(); ++r) {
    const double before = rows.number(r, "error"), after = rows.number(r + 1, "error");
    if (!(before >= error && error >= after) || before == after) continue;
    const double share = std::log(before / error) / std::log(before / after);
    const double x = std::exp((1 - share) * std::log(rows.number(r, column)) +
                              share * std::log(rows.number(r + 1, column)));
    least = std::fmin(least, x);
  }
  return least;
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
