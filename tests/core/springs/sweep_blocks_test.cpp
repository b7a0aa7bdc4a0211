// Which blocks a sweep computes, and that nothing is left in the scratch memory between them.
#include "core/springs/sweep_blocks.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/random_bodies.hpp"

namespace mss {
namespace {

constexpr std::ptrdiff_t no_block = -1;

/// Per site of a plane: the block that holds it.
std::vector<std::ptrdiff_t> block_of_site(const Body& body, const SweepBlocks& blocks, int width, int plane) {
  std::vector<std::ptrdiff_t> block(std::size_t(body.lattice().plane), no_block);
  std::ptrdiff_t count = 0;
  for (const BlockRun& run : blocks.of(plane)) {
    EXPECT_EQ((run.last - run.first) % width, 0);
    EXPECT_LE(run.last - run.first, SweepBlocks::piece * width);
    for (std::ptrdiff_t q = run.first; q < run.last; ++q) {
      EXPECT_EQ(block[std::size_t(q)], no_block) << "two blocks hold site " << q;
      block[std::size_t(q)] = count + (q - run.first) / width;
    }
    count += blocks.count(run);
  }
  EXPECT_EQ(std::size_t(count), blocks.before(plane + 1) - blocks.before(plane));
  return block;
}

TEST(SweepBlocks, HoldEveryParticleOnceAndBeginAtOne) {
  for (const auto& shape : testing::test_shapes())
    for (const int width : {2, 4, 8, 16}) {
      const Body body(testing::test_config(shape.voxels));
      const Lattice& lattice = body.lattice();
      const SweepBlocks blocks(body, width);
      for (int k = 0; k < lattice.planes(); ++k) {
        const auto block = block_of_site(body, blocks, width, k);
        for (std::ptrdiff_t q = 0; q < lattice.plane; ++q) {
          const bool particle = body.weights_at(lattice.plane * k + q).mass != 0;
          const std::ptrdiff_t here = block[std::size_t(q)];
          EXPECT_TRUE(!particle || here != no_block) << shape.name << " plane " << k << " site " << q;
          const bool begins = here != no_block && (q == 0 || block[std::size_t(q) - 1] != here);
          EXPECT_TRUE(!begins || particle) << shape.name << ": a block begins at an empty site";
        }
      }
    }
}

TEST(SweepBlocks, OfABallAreFewerThanThoseOfItsBox) {
  constexpr int n = 40, width = 8;
  VoxelGrid ball(n, n, n);
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const Vec3 from_centre = Vec3(i + 0.5, j + 0.5, k + 0.5) - Vec3::Constant(n / 2.0);
        ball.set(i, j, k, from_centre.norm() <= n / 2.0);
      }
  const auto blocks_per_particle = [](const VoxelGrid& voxels) {
    const Body body(testing::test_config(voxels));
    return double(SweepBlocks(body, width).before(body.lattice().planes())) / double(body.particle_count());
  };
  EXPECT_LT(blocks_per_particle(VoxelGrid::box(n, n, n)) * width, 1.01);
  EXPECT_LT(blocks_per_particle(ball) * width, 1.2);
}

TEST(SweepBlocks, ForgetWhatADivergedBodyLeft) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& shape : testing::test_shapes())
    for (const auto& kernel : runnable_copies<SweepKernel<double>>())
      for (const int threads : {1, 2}) {
        const Body body(testing::test_config(shape.voxels));
        SpringSystem<double> used(body, {}, {threads, kernel.name}), fresh(body, {}, {threads, kernel.name});
        auto state = used.rest_state(), diverged = used.rest_state();
        testing::randomise(body, state, 0.4, 0.5, 3);
        for (const std::ptrdiff_t site : body.sites()) diverged.x.set(site, Vec3::Constant(nan));
        Field<double> f(used.size()), expected(used.size());
        used.force(0, diverged.x, diverged.v, f);
        for (std::ptrdiff_t site = 0; site < body.lattice().sites; ++site) f.set(site, Vec3::Constant(7));
        used.force(0, state.x, state.v, f);
        fresh.force(0, state.x, state.v, expected);
        for (int k = 0; k < body.lattice().planes(); ++k)
          for (std::ptrdiff_t q = 0; q < body.lattice().used(); ++q) {
            const std::ptrdiff_t site = body.lattice().plane * k + q;
            ASSERT_EQ(f.at(site), expected.at(site)) << shape.name << " " << kernel.name << " site " << site;
          }
      }
}

}  // namespace
}  // namespace mss
