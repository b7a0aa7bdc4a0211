// Which samples of cells lie in a mesh, and what cells hold of them.
#include "core/mesh/mesh_fill.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <numbers>
#include <random>

#include "core/error.hpp"
#include "core/mesh/inside_samples.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/winding.hpp"

namespace mss {
namespace {

using ::testing::HasSubstr;

Vec3 random_vector(std::mt19937& rng) {
  std::uniform_real_distribution<> u(0, 1);
  const double x = u(rng), y = u(rng);
  return {x, y, u(rng)};
}

/// Mass of all cells over density [m^3], from the corners' shares.
double mass(const MeshFill& fill, int part = -1) {
  double sum = 0;
  for (int k = 0; k < fill.voxels.nz(); ++k)
    for (int j = 0; j < fill.voxels.ny(); ++j)
      for (int i = 0; i < fill.voxels.nx(); ++i) {
        if (!fill.voxels.at(i, j, k)) continue;
        for (const PartFill& p : fill.contents[fill.content_of[fill.voxels.index(i, j, k)]])
          if (part < 0 || p.part == part)
            for (const float c : p.fill.corner) sum += double(c) / 8;
      }
  return sum * std::pow(fill.cell_size, 3);
}

TEST(MeshFill, KeepsTheVolumeOfASphere) {
  const TriangleMesh sphere = icosphere(0.5, 40);
  std::mt19937 rng(1);
  for (const auto& [across, worst, least] : {std::tuple{5, 1e-2, 1e-5}, std::tuple{10, 1e-2, 1e-6},
                                             std::tuple{20, 1e-2, 0.0}, std::tuple{100, 1e-2, 0.0}}) {
    double largest = 0, squares = 0;
    for (int offset = 0; offset < (across == 100 ? 2 : 24); ++offset) {
      const MeshFill fill = fill_mesh(sphere, {.cell_size = 1.0 / across, .offset = random_vector(rng)});
      const MeshReport& report = fill.reports.at(0);
      EXPECT_NEAR(mass(fill), report.filled_volume, 1e-6 * report.filled_volume);
      EXPECT_TRUE(report.notes().empty());
      EXPECT_EQ(report.contested, 0);
      const double error = std::abs(report.filled_volume / report.true_volume - 1);
      largest = std::max(largest, error);
      squares += error * error / 24;
    }
    printf("%d across: largest %.2e rms %.2e\n", across, largest, std::sqrt(squares));
    EXPECT_LT(largest, worst);
    EXPECT_GE(largest, least);
  }
}

}  // namespace
}  // namespace mss
