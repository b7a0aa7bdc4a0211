#pragma once

#include <vector>

namespace mss {

/// The p-quantile, 0 <= p <= 1, of a sample of at least one number: linear between order statistics.
double quantile(std::vector<double> sample, double p);

/// Median and quartiles of a sample; NaN of an empty one.
struct Quartiles {
  double median, q1, q3;
};
Quartiles quartiles(const std::vector<double>& sample);

/// Of a[i] / b[i], samples taken in the same round, as far as both go: what disturbed one disturbed both.
Quartiles quartiles_of_ratio(const std::vector<double>& a, const std::vector<double>& b);

/// The t of Student's distribution within which, on either side of 0, `share` of it lies, 0 < share < 1.
double student_t(double share, int degrees_of_freedom);

/// y = coefficient x^exponent.
struct PowerLaw {
  double coefficient = 0;
  double exponent = 0;

  double at(double x) const;
  /// The x where the law takes the value y.
  double inverse(double y) const;
};

/// Least squares of log y on log x. Needs at least two different x, all numbers positive.
PowerLaw fit_power_law(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace mss
