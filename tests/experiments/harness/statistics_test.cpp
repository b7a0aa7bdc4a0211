#include "experiments/harness/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mss {
namespace {

TEST(Statistics, QuantilesLieBetweenOrderStatistics) {
  EXPECT_EQ(quantile({3}, 0.25), 3);
  EXPECT_EQ(quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_EQ(quantile({5, 1, 3, 2, 4}, 0.25), 2);
  EXPECT_EQ(quantile({5, 1, 3, 2, 4}, 1), 5);
}

TEST(Statistics, PowerLawIsRecovered) {
  std::vector<double> x, y, noisy;
  for (const double n : {20, 30, 50, 100}) {
    x.push_back(n);
    y.push_back(3e-9 * std::pow(n, 2.97));
    noisy.push_back(y.back() * (x.size() % 2 ? 1.1 : 1 / 1.1));
  }
  const PowerLaw exact = fit_power_law(x, y);
  EXPECT_NEAR(exact.exponent, 2.97, 1e-12);
  EXPECT_NEAR(exact.coefficient / 3e-9, 1, 1e-11);
  EXPECT_NEAR(exact.inverse(exact.at(42)), 42, 1e-10);
  // Least squares by hand: slope change = sum dx e / sum dx^2 with e = ±log 1.1.
  EXPECT_NEAR(fit_power_law(x, noisy).exponent - 2.97, -0.0724, 1e-3);
}

TEST(Statistics, StudentsTIsThatOfTables) {
  EXPECT_NEAR(student_t(0.95, 1), 12.7062, 1e-4);
  EXPECT_NEAR(student_t(0.95, 2), 4.3027, 1e-4);
  EXPECT_NEAR(student_t(0.95, 5), 2.5706, 1e-4);
  EXPECT_NEAR(student_t(0.99, 10), 3.1693, 1e-4);
  EXPECT_NEAR(student_t(0.95, 1000000), 1.9600, 1e-4);
}

}  // namespace
}  // namespace mss
