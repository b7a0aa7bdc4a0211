// Ropes and sheets: lattices without extent along some axes.
#include <gtest/gtest.h>

#include <array>
#include <map>

#include "core/base/error.hpp"
#include "core/kernels/dispatch.hpp"
#include "core/kernels/sweep.hpp"
#include "core/measures/measures.hpp"
#include "core/measures/particle_measures.hpp"
#include "core/springs/spring_system.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

using Cells = std::array<int, 3>;

/// Along every axis and in every plane, some of one link.
const std::vector<Cells> flat_cells{{7, 0, 0}, {0, 1, 0},  {0, 9, 0}, {0, 0, 11}, {19, 0, 0},
                                    {4, 3, 0}, {17, 5, 0}, {5, 0, 6}, {0, 6, 4},  {1, 0, 1}};

BodyConfig flat_body(const Cells& cells, const Damping& damping = {.law = Damping::Law::ratio, .zeta = 0.1}) {
  BodyConfig config{.voxels = VoxelGrid::box(cells[0], cells[1], cells[2]),
                    .cell_size = 0.2,
                    .thickness = 0.05,
                    .origin = Vec3(0.3, -0.1, 0.5),
                    .density = 900,
                    .springs = {.edge = 120},
                    .damping = damping};
  if (!config.is_solid() && config.voxels.dimensions() == 2) config.springs.face = 80;
  return config;
}

/// A spring of a rope or sheet as its definition has it: along an edge, or across a square.
struct PlainSpring {
  Cells a, b;
  double stiffness;
};

/// By places of the lattice. An edge at a sheet's rim has one square, which gives it half.
std::vector<PlainSpring> plain_springs(const BodyConfig& config) {
  std::vector<PlainSpring> springs;
  const Cells n = config.voxels.size();
  for (int k = 0; k <= n[2]; ++k)
    for (int j = 0; j <= n[1]; ++j)
      for (int i = 0; i <= n[0]; ++i) {
        const Cells at{i, j, k};
        for (std::size_t u = 0; u < 3; ++u) {
          if (at[u] == n[u]) continue;
          Cells next = at;
          ++next[u];
          double sides = 1;
          for (std::size_t w = 0; w < 3; ++w)
            if (w != u && n[w] > 0) sides = at[w] == 0 || at[w] == n[w] ? 0.5 : 1;
          springs.push_back({at, next, sides * config.springs.edge});
          for (std::size_t w = u + 1; w < 3; ++w) {
            if (at[w] == n[w]) continue;
            Cells beside = at, across = next;
            ++beside[w];
            ++across[w];
            springs.push_back({at, across, config.springs.face});
            springs.push_back({next, beside, config.springs.face});
          }
        }
      }
  return springs;
}

/// Of a particle, by how many of the box's ends it is at.
double plain_mass(const BodyConfig& config, const Cells& at) {
  double mass = config.density;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int n = config.voxels.size()[axis];
    mass *= n == 0 ? *config.thickness : config.cell_size;
    if (n > 0 && (at[axis] == 0 || at[axis] == n)) mass /= 2;
  }
  return mass;
}

std::ptrdiff_t flat_site(const Body& body, const Cells& at) {
  return body.lattice().site(at[0], at[1], at[2]);
}

TEST(FewerDimensions, HaveTheMassesAndSpringsOfWhatExists) {
  for (const Cells& cells : flat_cells) {
    const BodyConfig config = flat_body(cells);
    const Body body(config);
    const std::vector<PlainSpring> springs = plain_springs(config);
    std::map<std::pair<std::ptrdiff_t, std::ptrdiff_t>, double> expected;
    for (const PlainSpring& s : springs) {
      const auto [a, b] = std::minmax({flat_site(body, s.a), flat_site(body, s.b)});
      expected[{a, b}] = s.stiffness;
    }
    std::size_t found = 0;
    body.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot&, double k, double) {
      ++found;
      const auto spring = expected.find(std::minmax({a, b}));
      ASSERT_NE(spring, expected.end());
      EXPECT_NEAR(k, spring->second, 1e-12);
    });
    EXPECT_EQ(found, springs.size());
    EXPECT_EQ(body.spring_count(), springs.size());
    double mass = 0;
    for (const std::ptrdiff_t site : body.sites()) {
      EXPECT_NEAR(body.mass(site), plain_mass(config, body.lattice().coordinates(site)), 1e-12);
      mass += body.mass(site);
    }
    EXPECT_NEAR(mass, body.total_mass(), 1e-12);
    EXPECT_EQ(body.particle_count(), std::size_t((cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1)));
    std::size_t pieces = 0;
    body.for_each_piece([&](std::ptrdiff_t site) {
      ++pieces;
      for (const int c : body.corners()) EXPECT_GE(body.particle(site + body.lattice().corner(c)), 0);
    });
    EXPECT_EQ(pieces, body.cell_count());
    body.for_each_cell([](std::ptrdiff_t) { FAIL() << "has cells"; });
  }
}

/// Forces by the definition of springs and dampers, in a random state.
template <class Real>
double flat_force_error(const Cells& cells, const Damping& damping, const std::string& kernel, int threads) {
  const BodyConfig config = flat_body(cells, damping);
  const Body body(config);
  const Vec3 gravity(0.3, -0.2, -9.81);
  SpringSystem<Real> system(body, {.gravity = gravity}, {threads, kernel});
  State<Real> state = system.rest_state();
  testing::randomise(body, state, 0.3, 0.5, 3);
  Field<double> expected(system.size());
  for (const std::ptrdiff_t site : body.sites()) expected.set(site, body.mass(site) * gravity);
  double largest = 0, error = 0;
  for (const PlainSpring& s : plain_springs(config)) {
    const std::ptrdiff_t a = flat_site(body, s.a), b = flat_site(body, s.b);
    const Vec3 d = state.x.at(b) - state.x.at(a), u = d.normalized();
    const double rest = (body.rest_position(b) - body.rest_position(a)).norm();
    const double c =
        damping.coefficient(s.stiffness, body.mass(a), body.mass(b), rest, config.shear_modulus());
    const Vec3 f = (s.stiffness * (d.norm() - rest) + c * (state.v.at(b) - state.v.at(a)).dot(u)) * u;
    expected.set(a, expected.at(a) + f);
    expected.set(b, expected.at(b) - f);
  }
  Field<Real> f(system.size());
  system.force(0, state.x, state.v, f);
  for (const std::ptrdiff_t site : body.sites()) {
    largest = std::max(largest, expected.at(site).norm());
    error = std::max(error, (f.at(site) - expected.at(site)).norm());
  }
  return error / largest;
}

TEST(FewerDimensions, ForcesAreThoseOfTheirSpringsInEveryKernel) {
  for (const Cells& cells : flat_cells)
    for (const Damping& damping : {Damping{}, Damping{.law = Damping::Law::ratio, .zeta = 0.1},
                                   Damping{.law = Damping::Law::viscosity, .viscosity = 3}}) {
      for (const auto& kernel : runnable_copies<SweepKernel<double>>())
        EXPECT_LT(flat_force_error<double>(cells, damping, kernel.name, 1), 1e-12) << kernel.name;
      for (const auto& kernel : runnable_copies<SweepKernel<float>>())
        EXPECT_LT(flat_force_error<float>(cells, damping, kernel.name, 1), 2e-5) << kernel.name;
      EXPECT_LT(flat_force_error<double>(cells, damping, "", 3), 1e-12);
    }
}

TEST(FewerDimensions, ModelTheirMaterialInAPull) {
  for (const Cells& cells : {Cells{6, 0, 0}, Cells{6, 4, 0}}) {
    BodyConfig config = flat_body(cells, {});
    config.fill({.young = 1e5, .poisson = 0.3}, 0.5);  // nu of a sheet is 1/3, whatever is given
    const Body body(config);
    SpringSystem<double> system(body, {});
    const double strain = 1e-6;
    State<double> state = system.undeformed_state();
    for (const std::ptrdiff_t site : body.sites()) {
      const Vec3 rest = body.rest_position(site);
      state.x.set(site, rest + strain * Vec3(rest[0], -rest[1] / 3, 0));
    }
    Field<double> f(system.size());
    system.force(0, state.x, state.v, f);
    double pull = 0, across = 0;
    for (const std::ptrdiff_t site : body.sites()) {
      if (body.lattice().coordinates(site)[0] == 0) pull += f.axis(0)[site];
      across = std::max(across, std::abs(f.axis(1)[site]));
    }
    const double width = cells[1] == 0 ? 0.05 : cells[1] * 0.2;
    EXPECT_NEAR(pull / (1e5 * strain * width * 0.05), 1, 1e-5);
    EXPECT_LT(across, 1e-5 * pull);
    EXPECT_NEAR(config.young_of(config.springs, 0), 1e5, 1e-6);
  }
}

TEST(FewerDimensions, KeepMomentumAndSpinAndHaveNoVolume) {
  for (const Cells& cells : flat_cells) {
    const Body body(flat_body(cells));
    SpringSystem<double> system(body, {});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0.1, 0.3, 17);
    for (int step = 0; step < 20; ++step) {
      const Measures before = measure(system, state);
      system.kick_drift({.kick_before = 1e-4, .kick_after = 0, .drift_old = 0, .drift_new = 1e-4}, 1e-4, 1,
                        state);
      const Measures after = measure(system, state);
      const double scale = 0.3 * body.total_mass();
      EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * scale);
      EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 1e-11 * scale);
      EXPECT_EQ(after.volume_ratio, 1);
      EXPECT_EQ(after.volume_ratio_thesis, 1);
      EXPECT_EQ(after.min_jacobian, 1);
      EXPECT_GT(after.max_stretch, 0);
    }
    EXPECT_EQ(volume_ratio_at({body}, state.x, body.sites().front()), 1);
    EXPECT_EQ(jacobian_at({body}, state.x, body.sites().front()), 1);
  }
}

/// The bits of a run are those of one thread.
TEST(FewerDimensions, AreBitwiseEqualForAnyNumberOfThreads) {
  for (const Cells& cells : {Cells{0, 0, 40}, Cells{0, 12, 20}, Cells{12, 0, 20}, Cells{20, 12, 0}}) {
    const Body body(flat_body(cells));
    std::vector<State<double>> ends;
    for (const int threads : {1, 2, 3}) {
      SpringSystem<double> system(body, {.gravity = {0, 0, -9.81}}, {.threads = threads});
      State<double> state = system.rest_state();
      testing::randomise(body, state, 0.1, 0.3, 17);
      system.kick_drift({.kick_before = 1e-3, .kick_after = 0, .drift_old = 0, .drift_new = 1e-3}, 1e-3, 50,
                        state);
      ends.push_back(state);
    }
    for (const State<double>& end : ends) {
      EXPECT_TRUE((end.x.array() == ends.front().x.array()).all());
      EXPECT_TRUE((end.v.array() == ends.front().v.array()).all());
    }
  }
}

TEST(FewerDimensions, SplitIntoSmallerLinksOfTheSameMaterial) {
  BodyConfig config = flat_body({4, 2, 0});
  resample(config, 1, 3);
  EXPECT_EQ(config.voxels.size(), (Cells{12, 6, 0}));
  EXPECT_EQ(config.voxels.count(), 72U);
}

TEST(FewerDimensions, BoxesNeedSomeExtent) {
  EXPECT_THROW(VoxelGrid::box(0, 0, 0), InputError);
  EXPECT_THROW(VoxelGrid::box(2, -1, 2), InputError);
  EXPECT_EQ(VoxelGrid::box(3, 0, 2).dimensions(), 2);
  EXPECT_EQ(VoxelGrid::box(3, 0, 2).flat_axes(), 2);
  EXPECT_TRUE(VoxelGrid::box(3, 0, 2).at(2, -5, 1));
  EXPECT_FALSE(VoxelGrid::box(3, 0, 2).at(3, 0, 1));
}

}  // namespace
}  // namespace mss
