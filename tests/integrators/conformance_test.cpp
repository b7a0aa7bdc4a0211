// What every method in the registry must do: its declared order, its stability limit, repeatability, reset,
// and the same trajectory however often it is sampled.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

#include "core/base/error.hpp"
#include "core/measures/measures.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/integrator.hpp"
#include "tests/chain.hpp"
#include "tests/oscillator.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

class Method : public ::testing::TestWithParam<std::string> {
 protected:
  const IntegratorInfo& info() const { return find_integrator(GetParam()); }
};
class FixedStepMethod : public Method {};
class OrderedMethod : public Method {};  ///< of fixed step, for any system
class AdaptiveMethod : public Method {};
class LimitedMethod : public Method {};    ///< stable up to a step
class UnlimitedMethod : public Method {};  ///< of fixed step, stable at any
class SinglePrecisionMethod : public Method {};

double error_at(const IntegratorInfo& info, testing::Oscillator& system, double dt, double t_end) {
  auto state = system.start(0.8, 0.5);
  Work work;
  EXPECT_EQ(info.make<double>({.dt = dt})->advance(system, state, t_end, work), Status::ok);
  EXPECT_NEAR(state.t, t_end, 1e-9);
  return std::abs(state.x.axis(0)[0] - system.exact(0.8, 0.5, t_end));
}

/// Small, yet errors of that order are well above rounding.
double step_for(int order) {
  if (order > 4) return 1.0 / 4;
  return order > 2 ? 1.0 / 64 : 1.0 / 1024;
}

double observed_order(const IntegratorInfo& info, double damping, int declared) {
  testing::Oscillator system(2, damping);
  const double dt = step_for(declared);
  const double coarse = error_at(info, system, dt, 1), fine = error_at(info, system, dt / 2, 1);
  return std::log2(coarse / fine);
}

TEST_P(OrderedMethod, HasItsDeclaredOrderUndamped) {
  EXPECT_NEAR(observed_order(info(), 0, info().order_undamped), info().order_undamped, 0.05)
      << info().name << ": errors fall with another power of dt than IntegratorInfo::order_undamped says";
}
TEST_P(OrderedMethod, HasItsDeclaredOrderDamped) {
  EXPECT_NEAR(observed_order(info(), 0.6, info().order_damped), info().order_damped, 0.05)
      << info().name << ": errors fall with another power of dt than IntegratorInfo::order_damped says";
}

TEST_P(Method, FollowsHoldsWhereNothingIsFree) {
  BodyConfig config;
  config.voxels = VoxelGrid::box(1, 1, 2);
  config.fill({.young = 1e4, .poisson = 0.3}, 0.5);
  const Body body(config);
  const Environment environment{.holds = {{.box = {{0, 0, 0}, {1, 1, 2}}, .velocity = {0, 0, 1}}}};
  SpringSystem<double> system(body, environment);
  State<double> state = system.rest_state();
  Work work;
  ASSERT_EQ(info().make<double>({.dt = 0.01})->advance(system, state, 0.1, work), Status::ok);
  EXPECT_NEAR(state.t, 0.1, 1e-12);
  for (const std::ptrdiff_t site : body.sites())
    EXPECT_LT((state.x.at(site) - body.rest_position(site) - Vec3(0, 0, 0.1)).norm(), 1e-12)
        << info().name << ": what is held does not move as System::constrain() says";
}

TEST_P(AdaptiveMethod, ErrorFallsWithTheTolerance) {
  testing::Oscillator system(2, 0.6);
  const auto error = [&](double tolerance) {
    auto state = system.start(0.8, 0.5);
    Work work;
    EXPECT_EQ(info().make<double>({.dt = 0, .tolerance = tolerance})->advance(system, state, 3, work),
              Status::ok);
    EXPECT_EQ(state.t, 3);
    return std::abs(state.x.axis(0)[0] - system.exact(0.8, 0.5, 3));
  };
  // A pair's estimate is of the less accurate of its two solutions; the other errs the less, the higher its
  // order.
  const double least = info().name == "arkode_fehlberg" ? 1e-4 : 1e-3;
  for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
    EXPECT_LT(error(tolerance), 100 * tolerance) << info().name << " errs by far more than its tolerance";
    EXPECT_GT(error(tolerance), least * tolerance)
        << info().name << " errs by far less than its tolerance, and so takes more steps than it needs";
  }
}

constexpr int chain_length = 6;

/// How many steps a chain, its shortest wave excited, stays bounded; at most so many. Close to its limit a
/// stable Verlet reaches many times its initial amplitude.
long bounded_steps(const IntegratorInfo& info, double beta, double dt, long most) {
  testing::Chain chain(chain_length, beta);
  State<double> state{0, Field<double>(chain.size()), Field<double>(chain.size())};
  for (const std::ptrdiff_t i : chain.particles()) state.x.axis(0)[i] = i % 2 == 0 ? 1 : -0.9;
  Work work;
  const auto method = info.make<double>({.dt = dt});
  constexpr long sample = 4000;
  for (long steps = sample; steps <= most; steps += sample) {
    if (method->advance(chain, state, double(steps) * dt, work) != Status::ok) return steps - sample;
    if (state.x.array().abs().maxCoeff() > 1e6) return steps - sample;
  }
  return most;
}

/// Explicit Euler grows slowly just beyond its limit.
long many_steps(const IntegratorInfo& info) { return info.implicit ? 20000 : 400000; }

/// Whether it stays bounded over many steps.
bool holds(const IntegratorInfo& info, double beta, double dt) {
  return bounded_steps(info, beta, dt, many_steps(info)) == many_steps(info);
}

/// What the test equation predicts for the chain: the tightest of its modes' limits.
double chain_limit(const IntegratorInfo& info, double beta) {
  const testing::Chain chain(chain_length, beta);
  double limit = std::numeric_limits<double>::infinity();
  for (int mode = 1; mode <= chain_length; ++mode) {
    const double omega = chain.omega(mode);
    limit = std::min(limit, info.limit(omega, beta * omega * omega));
  }
  return limit;
}

/// Of a method that no undamped step is stable of: there Heun's, which grows by w^4 dt^4 / 8 a step, is seen
/// to.
constexpr double growing = 0.5;  // / omega

TEST_P(LimitedMethod, IsStableUpToThePredictedStep) {
  const double omega = testing::Chain(chain_length, 0).largest_omega();
  // Ranges of resonance are narrow, but motions grow in them at once; elsewhere they may grow slowly at
  // first.
  const double beyond = info().resonant_limit ? 1.0001 : 1.01;
  for (const double ratio : {0.0, 0.05, 0.5, 1.0, 3.0}) {  // of critical damping, for the fastest mode
    const double limit = chain_limit(info(), 2 * ratio / omega);
    if (limit == 0) {
      EXPECT_FALSE(holds(info(), 2 * ratio / omega, growing / omega))
          << info().name << " says that no step is stable at damping ratio " << ratio
          << ", and at dt = 0.5 / omega it does not blow up: IntegratorInfo::limit is too small";
      continue;
    }
    const long until_unbounded = bounded_steps(info(), 2 * ratio / omega, beyond * limit, many_steps(info()));
    EXPECT_LT(until_unbounded, many_steps(info()))
        << info().name << " stays bounded beyond the step that IntegratorInfo::limit says, at damping ratio "
        << ratio << ": the limit is too small";
    // Were the limit two percent too large, this step would be as far beyond the true one, and the other
    // three times as far: growth takes three times as many steps.
    const long enough = std::min(many_steps(info()), 20000 + 10 * until_unbounded);
    EXPECT_EQ(bounded_steps(info(), 2 * ratio / omega, 0.99 * limit, enough), enough)
        << info().name << " blows up at 0.99 of the step that IntegratorInfo::limit says, at damping ratio "
        << ratio << ": the limit is too large, or a step is wrong";
  }
}

TEST_P(LimitedMethod, GrowsAtLongerStepsToo) {
  const double omega = testing::Chain(chain_length, 0).largest_omega();
  const bool grows = !holds(info(), 0, std::max(1.01 * chain_limit(info(), 0), growing / omega));
  EXPECT_EQ(grows, !info().resonant_limit)
      << info().name << (grows ? " grows" : " does not grow")
      << " without damping at a step a percent beyond its limit: see IntegratorInfo::resonant_limit";
}

TEST_P(UnlimitedMethod, IsStableFarBeyondExplicitSteps) {
  const double omega = testing::Chain(chain_length, 0).largest_omega();
  for (const double ratio : {0.0, 0.5})
    EXPECT_TRUE(holds(info(), 2 * ratio / omega, 1000 * 2 / omega))
        << info().name << " blows up at 1000 times an explicit step, at damping ratio " << ratio
        << ": give it an IntegratorInfo::limit, or its step is wrong";
}

TEST(StableStep, IsTheTightestOfAllModes) {
  const IntegratorInfo& verlet = find_integrator("verlet");
  EXPECT_DOUBLE_EQ(stable_step(verlet, {.omega = 4}), 0.5);
  EXPECT_DOUBLE_EQ(stable_step(verlet, {.omega = 4, .damping = 3}), central_limit(4, 3));
  EXPECT_THROW(stable_step(find_integrator("explicit_euler"), {.omega = 3, .damping = 1}), InputError);
  EXPECT_EQ(stable_step(find_integrator("backward_euler"), {.omega = 3}),
            std::numeric_limits<double>::infinity());
}

/// A damped, spinning body in free fall.
struct ConformanceScenario {
  Body body{testing::test_config(VoxelGrid::box(3, 2, 4))};
  SpringSystem<double> system{body, {.gravity = Vec3(0, 0, -9.81)}, {.threads = 2}};
  State<double> state = system.rest_state();
  ConformanceScenario() { testing::randomise(body, state, 0.1, 0.5, 23); }
};

bool same_bits(const State<double>& a, const State<double>& b) {
  const auto bytes = std::size_t(a.x.size()) * sizeof(double);
  return std::memcmp(a.x.axis(0), b.x.axis(0), bytes) == 0 &&
         std::memcmp(a.v.axis(0), b.v.axis(0), bytes) == 0;
}

TEST_P(Method, RepeatsBitForBit) {
  ConformanceScenario one, other;
  Work work;
  const auto first = info().make<double>({.dt = 1e-4}), second = info().make<double>({.dt = 1e-4});
  EXPECT_EQ(first->advance(one.system, one.state, 0.05, work), Status::ok);
  EXPECT_EQ(second->advance(other.system, other.state, 0.05, work), Status::ok);
  EXPECT_TRUE(same_bits(one.state, other.state))
      << info().name << " computes something else the second time: it reads what it has not set";
  if (info().stepping == Stepping::adaptive)
    EXPECT_GT(work.steps, 10);
  else
    EXPECT_EQ(work.steps, 1000) << info().name
                                << " does not count its steps in Work, or takes others than dt";
  EXPECT_GE(work.force_evaluations, work.steps) << info().name << " does not count its forces in Work";
}

TEST_P(FixedStepMethod, DoesNotDependOnHowOftenItIsSampled) {
  ConformanceScenario once, often;
  Work work;
  const auto first = info().make<double>({.dt = 1e-4}), second = info().make<double>({.dt = 1e-4});
  first->advance(once.system, once.state, 0.02, work);
  for (int sample = 1; sample <= 20; ++sample)
    second->advance(often.system, often.state, sample * 1e-3, work);
  EXPECT_TRUE(same_bits(once.state, often.state))
      << info().name << " ends elsewhere where it is sampled: advance() must go on where the last one ended";
}

// Sites without a particle have numbers too. They must not grow: zero times infinity would reach particles.
TEST_P(Method, LeavesSitesWithoutParticlesAlone) {
  VoxelGrid ell = VoxelGrid::box(4, 3, 3);
  for (int i = 2; i < 4; ++i) ell.set(i, 1, 2, false);
  const Body body(testing::test_config(ell));
  const Vec3 origin = body.config().origin;
  SpringSystem<double> system(
      body, {.gravity = Vec3(0, 0, -0.1), .holds = {{.box = {origin, origin + Vec3(1, 1, 0)}}}},
      {.threads = 1});
  State<double> state = system.rest_state();
  const State<double> start = state;
  const auto method = info().make<double>({.dt = 1e-3});
  Work work;
  for (int sample = 1; sample <= 3; ++sample) {
    EXPECT_EQ(method->advance(system, state, sample * 0.02, work), Status::ok);
    method->reset();
  }
  const auto& sites = body.sites();
  int empty = 0;
  for (std::ptrdiff_t site = 0; site < body.lattice().size; ++site) {
    if (std::binary_search(sites.begin(), sites.end(), site)) continue;
    ++empty;
    EXPECT_LT((state.x.at(site) - start.x.at(site)).norm(), 1e-12)
        << info().name << " moves site " << site << ", which has no particle";
    EXPECT_LT(state.v.at(site).norm(), 1e-12)
        << info().name << " gives site " << site << ", which has no particle, a velocity";
  }
  EXPECT_GT(empty, 10);
}

TEST_P(Method, ResetForgets) {
  ConformanceScenario used, fresh;
  Work work;
  const auto method = info().make<double>({.dt = 1e-4});
  method->advance(used.system, used.state, 0.01, work);
  used.state = fresh.state;  // an edit
  method->reset();
  method->advance(used.system, used.state, 0.01, work);
  info().make<double>({.dt = 1e-4})->advance(fresh.system, fresh.state, 0.01, work);
  EXPECT_TRUE(same_bits(used.state, fresh.state))
      << info().name << " goes on with what it had before reset(), which must discard all history";
}

TEST_P(Method, FollowsHolds) {
  const Body body(testing::test_config(VoxelGrid::box(2, 2, 3)));
  const Vec3 low = body.config().origin, high = low + Vec3(0.4, 0.4, 0.6);
  const Hold fixed{.box = {low, {high[0], high[1], low[2]}}};
  const Hold pulled{
      .box = {{low[0], low[1], high[2]}, high}, .axes = {false, false, true}, .velocity = Vec3(0, 0, 1)};
  SpringSystem<double> system(body, {.gravity = Vec3::Zero(), .holds = {fixed, pulled}, .loads = {}});
  auto state = system.rest_state();
  Work work;
  ASSERT_EQ(info().make<double>({.dt = 1e-4})->advance(system, state, 0.1, work), Status::ok);
  for (const std::ptrdiff_t site : body.select(fixed.box.lower, fixed.box.upper)) {
    EXPECT_EQ(state.x.at(site), body.rest_position(site)) << info().name << " moves what is held";
    EXPECT_EQ(state.v.at(site), Vec3::Zero()) << info().name << " moves what is held";
  }
  double contraction = 0;
  for (const std::ptrdiff_t site : body.select(pulled.box.lower, pulled.box.upper)) {
    EXPECT_NEAR(state.x.at(site)[2], body.rest_position(site)[2] + 0.1, 1e-12)
        << info().name << ": what is pulled is not where System::constrain() has it at the end";
    contraction = std::max(contraction, std::abs(state.x.at(site)[0] - body.rest_position(site)[0]));
  }
  if (info().has_modulus) {
    EXPECT_GT(contraction, 1e-4) << info().name << " holds coordinates that are free";
  }
}

TEST(Registry, MakesNoMethodInAPrecisionThatItLacks) {
  for (const IntegratorInfo& info : integrators()) {
    if (info.make_single)
      EXPECT_NE(info.make<float>({}), nullptr) << info.name;
    else
      EXPECT_THROW(info.make<float>({}), InputError) << info.name;
  }
}

TEST_P(SinglePrecisionMethod, WorksInSinglePrecision) {
  const Body body(testing::test_config(VoxelGrid::box(3, 3, 3)));
  SpringSystem<float> single(body, {});
  SpringSystem<double> twice(body, {});
  auto a = single.rest_state();
  auto b = twice.rest_state();
  testing::randomise(body, a, 0.1, 0.2, 4);
  testing::randomise(body, b, 0.1, 0.2, 4);
  Work work;
  EXPECT_EQ(info().make<float>({.dt = 1e-4})->advance(single, a, 0.05, work), Status::ok);
  EXPECT_EQ(info().make<double>({.dt = 1e-4})->advance(twice, b, 0.05, work), Status::ok);
  // Position Verlet rounds x, of size 1, by half an epsilon a step, and every rounding stays in its velocity:
  // after N steps N^2 / 2 of them at worst. The others round a velocity of size 1 times dt instead, and x's
  // three coordinates stay rounded once a step.
  const double steps = 500, epsilon = std::numeric_limits<float>::epsilon();
  const double allowed = epsilon / 2 * steps * (info().name == "verlet" ? steps / 2 : std::sqrt(3.0));
  for (const std::ptrdiff_t site : body.sites())
    EXPECT_LT((a.x.at(site) - b.x.at(site)).norm(), allowed)
        << info().name << " rounds more in single precision than its arithmetic does";
}

TEST_P(LimitedMethod, ReportsDivergence) {
  ConformanceScenario s;
  Work work;
  EXPECT_EQ(info().make<double>({.dt = 1})->advance(s.system, s.state, 1e5, work), Status::non_finite)
      << info().name << " goes on with numbers that are not finite, or calls that something else";
  EXPECT_LT(work.steps, 100000) << info().name << " looks for numbers that are not finite too seldom";
}

/// Those methods of the registry to which a suite applies.
auto methods(bool (*applies)(const IntegratorInfo&)) {
  std::vector<std::string> names;
  for (const IntegratorInfo& info : integrators())
    if (applies(info)) names.push_back(info.name);
  return ::testing::ValuesIn(names);
}
const auto name = [](const auto& p) { return p.param; };
INSTANTIATE_TEST_SUITE_P(Registry, Method,
                         methods([](const IntegratorInfo& m) { return m.moves_particles(); }), name);
INSTANTIATE_TEST_SUITE_P(Registry, FixedStepMethod,
                         methods([](const IntegratorInfo& m) { return m.stepping == Stepping::fixed; }),
                         name);
INSTANTIATE_TEST_SUITE_P(Registry, OrderedMethod, methods([](const IntegratorInfo& m) {
                           return m.stepping == Stepping::fixed && !m.springs_only;
                         }),
                         name);
INSTANTIATE_TEST_SUITE_P(Registry, AdaptiveMethod,
                         methods([](const IntegratorInfo& m) { return m.stepping == Stepping::adaptive; }),
                         name);
INSTANTIATE_TEST_SUITE_P(Registry, LimitedMethod, methods([](const IntegratorInfo& m) {
                           return m.stepping == Stepping::fixed && m.limit != nullptr;
                         }),
                         name);
INSTANTIATE_TEST_SUITE_P(Registry, UnlimitedMethod, methods([](const IntegratorInfo& m) {
                           return !m.limit && m.stepping == Stepping::fixed && !m.springs_only;
                         }),
                         name);
INSTANTIATE_TEST_SUITE_P(Registry, SinglePrecisionMethod,
                         methods([](const IntegratorInfo& m) { return m.make_single != nullptr; }), name);

TEST(Registry, HasUniqueNamesAndSuggests) {
  EXPECT_GE(integrators().size(), 4U);
  try {
    find_integrator("velocity_verlt");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'velocity_verlet'"), std::string::npos);
  }
}

/// Positions and velocities after a few steps of a method with these options.
std::vector<Vec3> after_steps(std::string_view method, const IntegratorOptions& options) {
  ConformanceScenario s;
  Work work;
  EXPECT_EQ(find_integrator(method).make<double>(options)->advance(s.system, s.state, 10 * options.dt, work),
            Status::ok);
  std::vector<Vec3> values;
  for (const std::ptrdiff_t site : s.body.sites()) {
    values.push_back(s.state.x.at(site));
    values.push_back(s.state.v.at(site));
  }
  return values;
}

/// Methods that move bodies, but for those that are another one: how many texts may say that there are.
int distinct_methods(bool (*among)(const IntegratorInfo&)) {
  return int(std::count_if(integrators().begin(), integrators().end(), [&](const IntegratorInfo& info) {
    return info.moves_particles() && info.variant_of.empty() && among(info);
  }));
}

TEST(Registry, VariantsAreOfOtherMethodsAndSayWhatDiffers) {
  int variants = 0;
  for (const IntegratorInfo& info : integrators()) {
    EXPECT_EQ(info.variant_of.empty(), info.variation.empty()) << info.name;
    if (info.variant_of.empty()) continue;
    ++variants;
    EXPECT_TRUE(find_integrator(info.variant_of).variant_of.empty()) << info.name;
    EXPECT_NE(info.variant_of, info.name);
  }
  EXPECT_EQ(variants, 3);
}

/// "by N methods, N of its own and N of SUNDIALS, ... N more ... N names" of README.md are those of the
/// registry.
TEST(Registry, ReadmeCountsDistinctMethods) {
  const auto of_sundials = [](const IntegratorInfo& info) {
    return info.has_modulus && (info.name.starts_with("cvode_") || info.name.starts_with("arkode_"));
  };
  const int all = distinct_methods([](const IntegratorInfo& info) { return info.has_modulus; });
  const int foreign = distinct_methods(of_sundials);
  const auto variants = std::count_if(integrators().begin(), integrators().end(),
                                      [](const IntegratorInfo& info) { return !info.variant_of.empty(); });
  const auto equilibria =
      std::count_if(integrators().begin(), integrators().end(),
                    [](const IntegratorInfo& info) { return info.stepping == Stepping::equilibrium; });
  std::ifstream file(MSS_SOURCE_DIR "/README.md");
  const std::string readme((std::istreambuf_iterator<char>(file)), {});
  const auto says = [&](const std::string& words) { return readme.find(words) != std::string::npos; };
  EXPECT_TRUE(says("by " + std::to_string(all) + " methods, " + std::to_string(all - foreign) +
                   " of its own and " + std::to_string(foreign) + " of SUNDIALS"))
      << all << " methods move springs, " << foreign << " of them of SUNDIALS";
  EXPECT_TRUE(says("they rest by " + std::to_string(equilibria) + " more")) << equilibria;
  EXPECT_TRUE(says(std::to_string(variants) + " further names are variants")) << variants;
  EXPECT_EQ(distinct_methods([](const IntegratorInfo& info) { return !info.has_modulus; }), 1)
      << "README.md says that one method has no springs";
}

TEST(Variants, IterateAsTheirNamesSay) {
  constexpr double dt = 5e-3;
  EXPECT_EQ(after_steps("vbd:5", {.dt = dt}), after_steps("vbd", {.dt = dt, .iterations = 5}));
  EXPECT_NE(after_steps("vbd:5", {.dt = dt}), after_steps("vbd:6", {.dt = dt}));
  EXPECT_EQ(after_steps("backward_euler/lbfgs:3", {.dt = dt}),
            after_steps("backward_euler", {.dt = dt, .nonlinear_solver = "lbfgs", .iterations = 3}));
  EXPECT_EQ(find_integrator("vbd:5").name, "vbd:5");
  EXPECT_EQ(family_of("backward_euler/lbfgs:3"), "backward_euler/lbfgs");
  for (const IntegratorInfo& info : integrators())
    for (const std::string& ending : info.variants)
      EXPECT_EQ(find_integrator(info.name + ending).name, info.name + ending);
}

TEST(Variants, AreRefusedInWords) {
  const auto refusal = [](const char* method) -> std::string {
    try {
      find_integrator(method);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal("verlet:5").find("does not iterate"), std::string::npos) << refusal("verlet:5");
  EXPECT_NE(refusal("xpbd/lbfgs").find("needs no nonlinear solver"), std::string::npos)
      << refusal("xpbd/lbfgs");
  EXPECT_NE(refusal("backward_euler/lbgfs").find("'lbfgs'"), std::string::npos)
      << refusal("backward_euler/lbgfs");
  EXPECT_NE(refusal("vbx:5").find("'vbd'"), std::string::npos) << refusal("vbx:5");
  EXPECT_NE(refusal("backward_euler/").find("names no nonlinear solver"), std::string::npos);
  EXPECT_NE(refusal("backward_euler/:5").find("names no nonlinear solver"), std::string::npos);
  for (const char* method : {"vbd:", "vbd:0", "vbd:-1", "vbd:five", "vbd:5x", "vbd:99999999999"})
    EXPECT_NE(refusal(method).find("allowed: 1 to 1000"), std::string::npos)
        << method << ": " << refusal(method);
}

TEST(Verlet, IsSemiImplicitEulerInOtherVariables) {
  ConformanceScenario one, other;
  Work work;
  find_integrator("verlet").make<double>({.dt = 1e-4})->advance(one.system, one.state, 0.1, work);
  find_integrator("semi_implicit_euler")
      .make<double>({.dt = 1e-4})
      ->advance(other.system, other.state, 0.1, work);
  double largest = 0;
  for (const std::ptrdiff_t site : one.body.sites())
    largest = std::max(largest, (one.state.x.at(site) - other.state.x.at(site)).norm());
  EXPECT_LT(largest, 1e-10 * one.body.config().cell_size);
  EXPECT_GT(largest, 0);  // not the same code
}

}  // namespace
}  // namespace mss
