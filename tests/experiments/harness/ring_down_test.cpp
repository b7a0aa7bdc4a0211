// Frequency and damping of ring-downs, from signals whose both are known.
#include "experiments/harness/ring_down.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

namespace mss {
namespace {

using std::numbers::pi;

struct RingDownSignal {
  std::vector<double> times, values;

  RingDownSignal(double seconds, double step, const std::function<double(double)>& of) {
    for (int i = 0; i * step <= seconds; ++i) {
      times.push_back(i * step);
      values.push_back(of(i * step));
    }
  }
};

/// From 1 about a rest of 5, with 7.5 Hz and 6 percent of critical damping.
double ring_down_decay(double t) {
  const double zeta = 0.06, damped = 2 * pi * 7.5, omega = damped / std::sqrt(1 - zeta * zeta);
  return 5 + std::exp(-zeta * omega * t) * std::cos(damped * t);
}

TEST(RingDown, FindsFrequencyAndDampingOfOneMode) {
  const RingDownSignal fine(1, 1e-4, ring_down_decay);
  const RingDown found = ring_down(fine.times, fine.values, 5);
  EXPECT_EQ(found.status, "ok");
  EXPECT_NEAR(found.frequency, 7.5, 1e-6);
  EXPECT_NEAR(found.peak_damping_ratio, 0.06, 1e-7);
  EXPECT_NEAR(found.swing_damping_ratio, 0.06, 1e-7);
}

TEST(RingDown, WithoutARestItsPeaksHaveNoDecrement) {
  const RingDownSignal fine(1, 1e-4, ring_down_decay);
  const RingDown found = ring_down(fine.times, fine.values);
  EXPECT_EQ(found.status, "ok");
  EXPECT_NEAR(found.swing_damping_ratio, 0.06, 1e-7);
  EXPECT_TRUE(std::isnan(found.peak_damping_ratio));
}

TEST(RingDown, SamplesOfACameraAreEnough) {
  const RingDownSignal coarse(1, 0.01, ring_down_decay);  // 13 a period
  const RingDown found = ring_down(coarse.times, coarse.values, 5);
  EXPECT_NEAR(found.frequency, 7.5, 0.01);
  EXPECT_NEAR(found.peak_damping_ratio, 0.06, 1e-3);
  EXPECT_NEAR(found.swing_damping_ratio, 0.06, 1e-3);
}

// Of a parabola the vertex is exact, also between samples that are spaced unevenly.
TEST(RingDown, TurningPointsAreThoseOfParabolas) {
  const auto parabola = [](double t) { return 3 - 4 * (t - 0.37) * (t - 0.37); };
  const std::vector<double> times{0, 0.1, 0.3, 0.42, 0.7, 1};
  for (const double sign : {1.0, -1.0}) {
    std::vector<double> values;
    for (const double t : times) values.push_back(sign * parabola(t));
    const std::vector<Extremum> turns = turning_points(times, values);
    ASSERT_EQ(turns.size(), 1U);
    EXPECT_NEAR(turns[0].time, 0.37, 1e-14);
    EXPECT_NEAR(turns[0].value, sign * 3, 1e-14);
  }
  EXPECT_TRUE(turning_points({0, 1, 2, 3}, {1, 1, 1, 1}).empty());
  EXPECT_TRUE(turning_points({0, 1, 2, 3}, {1, 2, 3, 4}).empty());
  EXPECT_TRUE(turning_points({}, {}).empty());
}

TEST(RingDown, RippleMakesNoTurns) {
  const RingDownSignal rippled(
      1, 1e-4, [](double t) { return ring_down_decay(t) + 2e-3 * std::sin(2 * pi * 400 * t); });
  EXPECT_GT(turning_points(rippled.times, rippled.values, 0).size(), 200U);
  const RingDown found = ring_down(rippled.times, rippled.values, 5, 8);
  EXPECT_NEAR(found.frequency, 7.5, 0.05);
  EXPECT_NEAR(found.swing_damping_ratio, 0.06, 2e-3);
}

// A rest that drifts as relaxing materials' do makes upper peaks decay slower; swings do not see it.
TEST(RingDown, SwingsDoNotSeeARestThatDrifts) {
  const RingDownSignal drifting(1, 1e-4,
                                [](double t) { return ring_down_decay(t) + 0.2 * std::exp(-t / 3); });
  const RingDown found = ring_down(drifting.times, drifting.values, 5, 8);
  EXPECT_LT(found.peak_damping_ratio, 0.05);
  EXPECT_NEAR(found.swing_damping_ratio, 0.06, 2e-4);
}

TEST(RingDown, TakesTheFirstTurnsOfWhatChanges) {
  const RingDownSignal fine(2, 1e-4, [](double t) {
    return std::exp(-2 * t) * std::cos(2 * pi * (t < 0.5 ? 7.5 * t : 3.75 + 6 * (t - 0.5)));
  });
  EXPECT_NEAR(ring_down(fine.times, fine.values, no_value, 7).frequency, 7.5, 1e-3);
  EXPECT_LT(ring_down(fine.times, fine.values).frequency, 6.6);
}

TEST(RingDown, AGrowingMotionHasNegativeDamping) {
  const RingDownSignal growing(1, 1e-4,
                               [](double t) { return std::exp(2 * t) * std::cos(2 * pi * 7.5 * t); });
  const RingDown found = ring_down(growing.times, growing.values, 0);
  EXPECT_NEAR(found.peak_damping_ratio, -2 / (2 * pi * 7.5), 1e-4);
  EXPECT_NEAR(found.swing_damping_ratio, -2 / (2 * pi * 7.5), 1e-4);
}

TEST(RingDown, SaysWhatIsMissing) {
  const RingDownSignal brief(0.15, 1e-3, ring_down_decay), level(1, 1e-3, [](double) { return 5; });
  const RingDown few = ring_down(brief.times, brief.values);
  EXPECT_EQ(few.status, "fewer than three turning points");
  EXPECT_TRUE(std::isnan(few.frequency));
  EXPECT_EQ(ring_down(level.times, level.values).status, "fewer than three turning points");
  EXPECT_EQ(ring_down(std::vector<double>{}, {}).status, "fewer than three turning points");
  EXPECT_EQ(ring_down({{0.1, 1}, {0.2, -1}, {0.3, 0.8}}).status, "ok");
  EXPECT_EQ(ring_down({{0.1, 1}, {0.2, -1}, {0.3, -2}}).status, "maxima and minima are not in turn");
  EXPECT_EQ(ring_down({{0.1, 1}, {0.1, -1}, {0.3, 1}}).status, "times do not ascend");
  RingDownSignal whole(1, 1e-3, ring_down_decay);
  EXPECT_EQ(ring_down(whole.times, whole.values, 5.9).status, "fewer than two upper peaks above the rest");
  EXPECT_EQ(ring_down(whole.times, {1, 2}).status, "not as many values as times");
  EXPECT_THROW(turning_points(whole.times, {1, 2}), std::invalid_argument);
  whole.values[7] = no_value;
  EXPECT_EQ(ring_down(whole.times, whole.values).status, "a number is missing");
  EXPECT_THROW(turning_points(whole.times, whole.values), std::invalid_argument);
  whole.values[7] = 5;
  std::swap(whole.times[3], whole.times[4]);
  EXPECT_EQ(ring_down(whole.times, whole.values).status, "times do not ascend");
}

}  // namespace
}  // namespace mss
