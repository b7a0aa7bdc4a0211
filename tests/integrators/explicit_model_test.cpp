// A model for explicit methods alone: no tangents, no stubs. Other methods must refuse it in one sentence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/error.hpp"
#include "integrators/integrator.hpp"

namespace mss {
namespace {

/// Two bodies that attract each other by gravity, G = 1, each of mass 1/2.
class TwoBodies final : public System<double> {
 public:
  std::ptrdiff_t size() const override { return 2; }
  const std::vector<std::ptrdiff_t>& particles() const override { return particles_; }
  double mass(std::ptrdiff_t) const override { return 0.5; }
  void force(double, const Field<double>& x, const Field<double>&, Field<double>& f) override {
    const Vec3 d = x.at(1) - x.at(0);
    const Vec3 pull = mass(0) * mass(1) / std::pow(d.norm(), 3) * d;
    f.set(0, pull);
    f.set(1, -pull);
  }

 private:
  std::vector<std::ptrdiff_t> particles_{0, 1};
};

/// On a circle of diameter 1, which they complete in 2 pi.
State<double> circle() {
  State<double> state{0, Field<double>(2), Field<double>(2)};
  for (const std::ptrdiff_t i : {0, 1}) {
    state.x.set(i, Vec3(i == 0 ? -0.5 : 0.5, 0, 0));
    state.v.set(i, Vec3(0, i == 0 ? -0.5 : 0.5, 0));
  }
  return state;
}

/// Distance from the start after one turn.
double missed(const std::string& method, double dt) {
  TwoBodies system;
  State<double> state = circle();
  Work work;
  EXPECT_EQ(find_integrator(method)
                .make<double>({.dt = dt, .tolerance = 1e-9})
                ->advance(system, state, 2 * std::numbers::pi, work),
            Status::ok);
  return (state.x.at(0) - circle().x.at(0)).norm();
}

TEST(ExplicitModel, IsDrivenByVelocityVerletAtSecondOrder) {
  const double coarse = missed("velocity_verlet", std::numbers::pi / 50);
  const double fine = missed("velocity_verlet", std::numbers::pi / 100);
  EXPECT_GT(coarse, 0);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.05);
}

TEST(ExplicitModel, IsDrivenByExplicitAdaptiveMethods) {
  for (const std::string method : {"arkode_erk", "arkode_verner", "arkode_fehlberg", "cvode_adams"})
    EXPECT_LT(missed(method, 0), 1e-5) << method;
}

TEST(ExplicitModel, IsRefusedByEveryImplicitMethodInOneSentence) {
  int refused = 0;
  for (const IntegratorInfo& method : integrators()) {
    if (!method.implicit) continue;
    for (const std::string linear_solver : {"cholmod", "pcg", "matrix_free"}) {
      TwoBodies system;
      State<double> state = circle();
      Work work;
      const auto integrator = method.make<double>({.linear_solver = linear_solver});
      try {
        integrator->advance(system, state, 0.1, work);
        ADD_FAILURE() << method.name << " with " << linear_solver;
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), ::testing::HasSubstr("has no tangents")) << method.name;
        EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("\n")));
        ++refused;
      }
    }
  }
  EXPECT_EQ(refused, 3 * 11);
}

}  // namespace
}  // namespace mss
