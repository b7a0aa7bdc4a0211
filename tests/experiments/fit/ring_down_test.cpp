#include "experiments/fit/ring_down.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace mss::fit {
namespace {

constexpr double frequency = 7.7, zeta = 0.05;  ///< of the damped vibration [Hz]

/// A decaying cosine about a place of rest that creeps, `every` seconds, with noise.
std::vector<Extremum> ring(double every, double creep = 0, double noise = 0) {
  const double omega = 2 * std::numbers::pi * frequency, decay = zeta / std::sqrt(1 - zeta * zeta) * omega;
  std::vector<double> t, x;
  for (int i = 0; i * every < 0.8; ++i) {
    t.push_back(i * every);
    x.push_back(-0.006 + creep * t.back() + 0.006 * std::exp(-decay * t.back()) * std::cos(omega * t.back()) +
                noise * std::sin(1e4 * i));
  }
  return extrema_of(t, x);
}

TEST(RingDown, HasTheFrequencyAndDampingOfADecayingCosine) {
  const auto found = ring_down_of(ring(0.001));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->frequency, frequency, 1e-4 * frequency);
  EXPECT_NEAR(found->damping_ratio, zeta, 1e-3 * zeta);
}

TEST(RingDown, DoesNotDependOnWhereItRestsNorOnNoise) {
  const auto creeping = ring_down_of(ring(0.001, 3e-4));
  ASSERT_TRUE(creeping);
  EXPECT_NEAR(creeping->damping_ratio, zeta, 0.01 * zeta);
  const auto noisy = ring_down_of(ring(0.001, 0, 3e-5));
  ASSERT_TRUE(noisy);
  EXPECT_NEAR(noisy->frequency, frequency, 0.01 * frequency);
  EXPECT_NEAR(noisy->damping_ratio, zeta, 0.05 * zeta);
}

TEST(RingDown, SamplesOfATenthOfAPeriodAreEnough) {
  const auto coarse = ring_down_of(ring(0.013));
  ASSERT_TRUE(coarse);
  EXPECT_NEAR(coarse->frequency, frequency, 0.002 * frequency);
  EXPECT_NEAR(coarse->damping_ratio, zeta, 0.02 * zeta);
}

TEST(RingDown, NeedsThreeExtrema) {
  EXPECT_FALSE(ring_down_of({}));
  EXPECT_FALSE(ring_down_of({{0.1, 1}, {0.2, -1}}));
  EXPECT_TRUE(ring_down_of({{0.1, 1}, {0.2, -1}, {0.3, 0.8}}));
  EXPECT_TRUE(extrema_of({0, 1, 2, 3}, {1, 1, 1, 1}).empty());
  EXPECT_TRUE(extrema_of({0, 1, 2, 3}, {1, 2, 3, 4}).empty());
  EXPECT_TRUE(extrema_of({0, 1}, {1, 2}).empty());
}

}  // namespace
}  // namespace mss::fit
