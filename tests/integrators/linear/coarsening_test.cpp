// Bodies on coarser lattices: what they keep of the fine body, and how fields pass between the two.
#include "integrators/linear/coarsening.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/random_bodies.hpp"

namespace mss {
namespace {

const Parallel in_order = [](std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) {
  for (std::ptrdiff_t i = 0; i < count; ++i) task(i);
};

struct Pair {
  explicit Pair(const VoxelGrid& voxels)
      : fine(testing::test_config(voxels)), coarse(coarsened(fine.config())) {}
  /// 1 at particles with random factors in between.
  static Field<float> random_field(const Body& body, unsigned seed) {
    State<float> state{0, Field<float>(body.lattice().size), Field<float>(body.lattice().size)};
    testing::randomise(body, state, 1, 1, seed);
    return state.v;
  }
  static double inner(const Body& body, const Field<float>& a, const Field<float>& b) {
    double sum = 0;
    for (const std::ptrdiff_t site : body.sites()) sum += a.at(site).dot(b.at(site));
    return sum;
  }
  Body fine, coarse;
  LatticeTransfer transfer{fine.lattice(), coarse.lattice()};
};

TEST(Coarsening, KeepsMassAndStiffnessOfOddAndRaggedBodies) {
  for (const auto& shape : testing::test_shapes()) {
    Pair p(shape.voxels);
    EXPECT_NEAR(p.coarse.total_mass(), p.fine.total_mass(), 1e-6 * p.fine.total_mass()) << shape.name;
    const CubicStiffness fine = cubic_stiffness(p.fine.config().springs, p.fine.config().cell_size),
                         coarse = cubic_stiffness(p.coarse.config().springs, p.coarse.config().cell_size);
    EXPECT_DOUBLE_EQ(coarse.c11, fine.c11);
    EXPECT_DOUBLE_EQ(coarse.c44, fine.c44);
    for (const Body* body : {&p.fine, &p.coarse}) {
      double mass = 0;
      for (const std::ptrdiff_t site : body->sites()) mass += body->mass(site);
      EXPECT_NEAR(mass, body->total_mass(), 1e-9 * mass) << shape.name;
    }
  }
}

/// [m^3] by part.
std::vector<double> volumes(const Body& body) {
  std::vector<double> of_part(body.parts().size());
  body.for_each_cell([&](std::ptrdiff_t site) {
    for (const auto& [part, fill] : body.content_at(site))
      of_part[std::size_t(part)] += double(fill.share()) * body.cell_volume();
  });
  return of_part;
}

TEST(Coarsening, KeepsEveryPartsVolumeAndStiffness) {
  unsigned seed = 0;
  for (const auto& shape : testing::test_shapes()) {
    const Body fine(testing::mixed_config(shape.voxels, ++seed)), coarse(coarsened(fine.config()));
    EXPECT_NEAR(coarse.total_mass(), fine.total_mass(), 1e-6 * fine.total_mass()) << shape.name;
    for (std::size_t part = 0; part < 3; ++part) {
      EXPECT_NEAR(volumes(coarse)[part], volumes(fine)[part], 1e-6 * fine.volume()) << shape.name << part;
      const double c44 = cubic_stiffness(fine.parts()[part].springs, fine.config().cell_size).c44;
      EXPECT_DOUBLE_EQ(cubic_stiffness(coarse.parts()[part].springs, coarse.config().cell_size).c44, c44);
    }
  }
}

TEST(Coarsening, KeepsTheViscosity) {
  for (const Damping& damping : {Damping{.law = Damping::Law::ratio, .zeta = 0.3},
                                 Damping{.law = Damping::Law::viscosity, .viscosity = 20}}) {
    BodyConfig fine = testing::test_config(VoxelGrid::box(4, 4, 4));
    fine.damping = damping;
    const auto viscosity = [](const BodyConfig& body) {
      const double mass = body.density * std::pow(body.cell_size, 3);
      return body.damping.coefficient(body.springs.edge, mass, mass, body.cell_size, body.shear_modulus()) /
             body.cell_size;
    };
    EXPECT_NEAR(viscosity(coarsened(fine)), viscosity(fine), 1e-12 * viscosity(fine));
  }
}

TEST(Coarsening, RestrictionIsTheTransposeOfInterpolation) {
  for (const auto& shape : testing::test_shapes()) {
    Pair p(shape.voxels);
    const Field<float> a = Pair::random_field(p.fine, 3), b = Pair::random_field(p.coarse, 4);
    Field<float> up(p.fine.lattice().size), down(p.coarse.lattice().size);
    p.transfer.interpolate_add(b, up, in_order);
    p.transfer.restrict_to(a, down, in_order);
    const double above = Pair::inner(p.fine, a, up), below = Pair::inner(p.coarse, b, down);
    EXPECT_NEAR(above, below, 1e-5 * std::sqrt(Pair::inner(p.fine, a, a) * Pair::inner(p.fine, up, up)))
        << shape.name;
  }
}

TEST(Coarsening, InterpolatesLinearFieldsExactly) {
  const auto linear = [](const Vec3& x) { return Vec3(1 + x[0] - 2 * x[1], x[2], x[0] + x[1] + 3 * x[2]); };
  for (const auto& shape : testing::test_shapes()) {
    Pair p(shape.voxels);
    Field<float> coarse(p.coarse.lattice().size), fine(p.fine.lattice().size);
    for (const std::ptrdiff_t site : p.coarse.sites()) coarse.set(site, linear(p.coarse.rest_position(site)));
    p.transfer.interpolate_add(coarse, fine, in_order);
    for (const std::ptrdiff_t site : p.fine.sites())
      EXPECT_LT((fine.at(site) - linear(p.fine.rest_position(site))).norm(), 1e-5) << shape.name;
  }
}

// Also beyond the body, where odd sizes and ragged shapes have coarse particles and no fine ones.
TEST(Coarsening, PlacesCoarseParticlesOfABodyThatDeformsAffinely) {
  Eigen::Matrix3d f;
  f << 0.6, -0.7, 0.1, 0.8, 0.5, -0.2, 0.1, 0.3, 1.2;
  for (const auto& shape : testing::test_shapes()) {
    Pair p(shape.voxels);
    Field<float> fine(p.fine.lattice().size), coarse(p.coarse.lattice().size);
    for (const std::ptrdiff_t site : p.fine.sites()) fine.set(site, f * p.fine.rest_position(site));
    coarsen_positions(p.fine, fine, p.coarse, coarse);
    for (const std::ptrdiff_t site : p.coarse.sites())
      EXPECT_LT((coarse.at(site) - f * p.coarse.rest_position(site)).norm(), 1e-5) << shape.name;
  }
}

}  // namespace
}  // namespace mss
