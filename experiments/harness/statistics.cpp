#include "experiments/harness/statistics.hpp"

#include <algorithm>
#include <cmath>

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
