// Splitting methods satisfy the conditions of their order: their errors on motion that is not linear fall
// with it down to where the digits of their coefficients end.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "integrators/integrator.hpp"

namespace mss {
namespace {

using SplitReal = long double;
using SplitVector = std::array<SplitReal, 4>;  // of two particles in a plane

/// A chain of two masses and two springs that turn and stretch, under gravity: the first end is held.
SplitVector chain_acceleration(const SplitVector& x) {
  const auto pull = [](SplitReal dx, SplitReal dy, SplitReal length) {
    return 3 * (1 - length / std::sqrt(dx * dx + dy * dy));
  };
  const SplitReal first = pull(x[0] + 1, x[1], 0.8L), second = pull(x[2] - x[0] + 1, x[3] - x[1], 1.1L);
  const SplitReal fx = second * (x[2] - x[0] + 1), fy = second * (x[3] - x[1]);
  return {fx - first * (x[0] + 1), fy - first * x[1], -fx, -fy - 0.3L};
}

struct SplitState {
  SplitVector x{0.1L, 0.2L, 0.3L, -0.2L}, v{0.3L, -0.1L, 0.2L, 0.5L};
};

void split_kick(SplitState& state, SplitReal share) {
  const SplitVector a = chain_acceleration(state.x);
  for (std::size_t i = 0; i < a.size(); ++i) state.v[i] += share * a[i];
}

void split_drift(SplitState& state, SplitReal share) {
  for (std::size_t i = 0; i < state.x.size(); ++i) state.x[i] += share * state.v[i];
}

/// Two half kicks that meet between steps are one part, with which steps begin: here the first half of it
/// ends the last step.
SplitState split_motion(SplitState state, const std::vector<DriftKick>& parts, SplitReal dt, int steps) {
  const bool kick_first = parts.front().drift == 0;
  const SplitReal half = kick_first ? parts.front().kick * dt / 2 : 0;
  for (int n = 0; n < steps; ++n) {
    split_kick(state, half);
    for (std::size_t i = kick_first ? 1 : 0; i < parts.size(); ++i) {
      split_drift(state, parts[i].drift * dt);
      split_kick(state, parts[i].kick * dt);
    }
    split_kick(state, half);
  }
  return state;
}

/// After a second.
SplitState split_end(const std::string& method, int steps) {
  return split_motion({}, find_integrator(method).splitting, 1 / SplitReal(steps), steps);
}

SplitReal split_distance(const SplitState& a, const SplitState& b) {
  SplitReal largest = 0;
  for (std::size_t i = 0; i < a.x.size(); ++i)
    largest = std::max({largest, std::abs(a.x[i] - b.x[i]), std::abs(a.v[i] - b.v[i])});
  return largest;
}

class Splitting : public ::testing::TestWithParam<std::string> {
 protected:
  const IntegratorInfo& info() const { return find_integrator(GetParam()); }
};

TEST_P(Splitting, PartsMakeAStep) {
  SplitReal drift = 0, kick = 0;
  for (const DriftKick& part : info().splitting) drift += part.drift, kick += part.kick;
  EXPECT_NEAR(double(drift), 1, 1e-15);
  EXPECT_NEAR(double(kick), 1, 1e-15);
}

TEST_P(Splitting, IsItsOwnInverse) {
  const auto turned = [](SplitState state) {
    for (SplitReal& v : state.v) v = -v;
    return state;
  };
  const SplitState back = split_motion(turned(split_end(GetParam(), 4)), info().splitting, 0.25L, 4);
  EXPECT_LT(split_distance(turned(back), {}), 1e-17L);
}

TEST_P(Splitting, ErrorsOfNonlinearMotionFallWithItsOrder) {
  const SplitState exact = split_end("srkn8", 400);
  EXPECT_LT(split_distance(exact, split_end("srkn6", 2000)), 1e-16L);
  SplitReal before = split_distance(split_end(GetParam(), 4), exact);
  for (int steps = 8; steps <= 32; steps *= 2) {
    const SplitReal error = split_distance(split_end(GetParam(), steps), exact);
    EXPECT_NEAR(std::log2(double(before / error)), info().order_undamped, 0.1) << steps << " steps";
    before = error;
  }
}

std::vector<std::string> splitting_methods() {
  std::vector<std::string> names;
  for (const IntegratorInfo& info : integrators())
    if (!info.splitting.empty()) names.push_back(info.name);
  return names;
}
INSTANTIATE_TEST_SUITE_P(Registry, Splitting, ::testing::ValuesIn(splitting_methods()),
                         [](const auto& p) { return p.param; });

// Where eigenvalues meet at -1: a range of steps that a search along a grid passes over.
TEST(SplittingLimit, IsWhereTheFirstNarrowRangeBegins) {
  const auto grows_at = [](const IntegratorInfo& info, double dt) {
    long double x[2] = {1, 0}, v[2] = {0, 1};
    for (const auto [drift, kick] : info.splitting)
      for (int i = 0; i < 2; ++i) {
        x[i] += drift * dt * v[i];
        v[i] -= kick * dt * x[i];
      }
    return std::abs(x[0] + v[1]) > 2;
  };
  for (const char* name : {"srkn6", "srkn8"}) {
    const IntegratorInfo& info = find_integrator(name);
    const double limit = info.limit(1, 0);
    EXPECT_TRUE(grows_at(info, limit * (1 + 1e-6))) << name;
    EXPECT_FALSE(grows_at(info, limit * 1.01)) << name;
    for (double dt = 1e-3; dt < limit * (1 - 1e-6); dt += 1e-3)
      EXPECT_FALSE(grows_at(info, dt)) << name << dt;
    EXPECT_NEAR(50 * info.limit(50, 0), limit, 1e-10);
  }
}

}  // namespace
}  // namespace mss
