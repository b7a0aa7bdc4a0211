#include "experiments/harness/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiments/harness/table.hpp"

namespace mss {

double quantile(std::vector<double> sample, double p) {
  std::sort(sample.begin(), sample.end());
  const double place = p * double(sample.size() - 1);
  const auto below = std::size_t(place);
  const std::size_t above = std::min(below + 1, sample.size() - 1);
  return sample[below] + (place - double(below)) * (sample[above] - sample[below]);
}

Quartiles quartiles(const std::vector<double>& sample) {
  if (sample.empty()) return {no_value, no_value, no_value};
  return {quantile(sample, 0.5), quantile(sample, 0.25), quantile(sample, 0.75)};
}

Quartiles quartiles_of_ratio(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) ratios.push_back(a[i] / b[i]);
  return quartiles(ratios);
}

namespace {

/// The share of Student's distribution between -t and t, t = sqrt(n) tan(angle): the finite sums of
/// Abramowitz, Stegun, Handbook of Mathematical Functions, 26.7.3 and 26.7.4.
double share_within(double angle, int n) {
  const double square = std::pow(std::cos(angle), 2);
  double term = n % 2 == 0 ? 1 : std::cos(angle), sum = n == 1 ? 0 : term;
  for (int k = n % 2 == 0 ? 2 : 3; k <= n - 2; k += 2) sum += term *= square * (k - 1) / k;
  return n % 2 == 0 ? std::sin(angle) * sum : 2 / std::numbers::pi * (angle + std::sin(angle) * sum);
}

}  // namespace

double student_t(double share, int degrees_of_freedom) {
  const int n = std::min(degrees_of_freedom, 100000);  // then it is normal to six digits
  double low = 0, high = std::numbers::pi / 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (share_within(middle, n) < share ? low : high) = middle;
  }
  return std::sqrt(double(n)) * std::tan(low);
}

double PowerLaw::at(double x) const { return coefficient * std::pow(x, exponent); }
double PowerLaw::inverse(double y) const { return std::pow(y / coefficient, 1 / exponent); }

PowerLaw fit_power_law(const std::vector<double>& x, const std::vector<double>& y) {
  const auto count = double(x.size());
  double mean_x = 0, mean_y = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += std::log(x[i]) / count;
    mean_y += std::log(y[i]) / count;
  }
  double covariance = 0, variance = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double dx = std::log(x[i]) - mean_x;
    covariance += dx * (std::log(y[i]) - mean_y);
    variance += dx * dx;
  }
  const double exponent = covariance / variance;
  return {std::exp(mean_y - exponent * mean_x), exponent};
}

}  // namespace mss
