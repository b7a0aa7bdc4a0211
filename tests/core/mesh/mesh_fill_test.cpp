// Which samples of cells lie in a mesh, and what cells hold of them.
#include "core/mesh/mesh_fill.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <numbers>
#include <random>

#include "core/base/error.hpp"
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

/// Every cell of a fill with its content.
template <class Visit>
void for_each_cell(const MeshFill& fill, Visit&& visit) {
  for (int k = 0; k < fill.voxels.nz(); ++k)
    for (int j = 0; j < fill.voxels.ny(); ++j)
      for (int i = 0; i < fill.voxels.nx(); ++i)
        if (fill.voxels.at(i, j, k))
          visit(Vec3(i, j, k), fill.contents[fill.content_of[fill.voxels.index(i, j, k)]]);
}

/// Mass over density [m^3] and first moment [m^4] of the corners' shares, of one part or of all.
std::pair<double, Vec3> mass_moment(const MeshFill& fill, int part = -1) {
  double mass = 0;
  Vec3 moment = Vec3::Zero();
  const double eighth = std::pow(fill.cell_size, 3) / 8;
  for_each_cell(fill, [&](const Vec3& at, const CellContent& content) {
    for (const PartFill& p : content)
      for (unsigned c = 0; c < 8; ++c) {
        if (part >= 0 && p.part != part) continue;
        mass += eighth * double(p.fill.corner[c]);
        moment += eighth * double(p.fill.corner[c]) *
                  (fill.origin + fill.cell_size * (at + Vec3(c & 1, c >> 1 & 1, c >> 2)));
      }
  });
  return {mass, moment};
}

TEST(MeshFill, KeepsTheVolumeOfASphere) {
  const TriangleMesh sphere = icosphere(0.5, 40);
  std::mt19937 rng(1);
  for (const int across : {5, 10, 20, 100})
    for (int offset = 0; offset < (across == 100 ? 2 : 24); ++offset) {
      const MeshFill fill = fill_mesh(sphere, {.cell_size = 1.0 / across, .offset = random_vector(rng)});
      const MeshReport& report = fill.reports.at(0);
      // to half a sample
      const double sample = std::pow(0.25 / across, 3);
      EXPECT_NEAR(report.filled_volume, report.true_volume, 0.501 * sample) << across;
      EXPECT_NEAR(report.true_volume, std::numbers::pi / 6, 2e-4);
      EXPECT_TRUE(report.notes().empty());
      EXPECT_EQ(report.contested, 0);
      const auto [mass, moment] = mass_moment(fill);
      EXPECT_NEAR(mass, report.filled_volume, 1e-7 * report.filled_volume) << across;
      EXPECT_LT((moment / mass).norm(), 0.05 / across) << across;
    }
}

TEST(MeshFill, SamplesAloneAreNearTheVolume) {
  // what match_volume has to do: .24 percent rms at 5 across, falling with the square of the cell size
  const TriangleMesh sphere = icosphere(0.5, 40);
  std::mt19937 rng(2);
  double squares = 0;
  for (int trial = 0; trial < 24; ++trial) {
    const SampleGrid grid{
        .origin = Vec3::Constant(-0.6) + 0.1 * random_vector(rng), .cell_size = 0.2, .cells = {6, 6, 6}};
    const InsideSamples samples = find_inside(sphere, sphere.triangles.size(), 1, grid);
    squares += std::pow(double(samples.inside) * std::pow(0.05, 3) / enclosed_volume(sphere) - 1, 2) / 24;
  }
  EXPECT_NEAR(std::sqrt(squares), 0.002, 0.001);
}

/// Checks every sample against the sum of solid angles; returns how many were compared.
int compare_with_winding(const TriangleMesh& mesh, double orientation, const SampleGrid& grid) {
  const std::vector<OpenEdge> open = open_edges(mesh);
  const InsideSamples samples = find_inside(closed(mesh, open), mesh.triangles.size(), orientation, grid);
  int compared = 0;
  for (std::size_t cell = 0; cell < grid.cell_count(); ++cell)
    for (int bit = 0; bit < 64; ++bit) {
      const Vec3 x = grid.sample(cell, bit);
      double winding = 0;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        winding += orientation * solid_angle(a - x, b - x, c - x) / (4 * std::numbers::pi);
      }
      if (std::abs(winding - 0.5) < (open.empty() ? 1e-6 : 0.02)) continue;  // the dipoles' error
      ++compared;
      EXPECT_EQ(samples.masks[cell] >> bit & 1, winding > 0.5 ? 1U : 0U) << x.transpose() << " " << winding;
    }
  return compared;
}

TEST(MeshFill, InsideIsWhereTheWindingNumberSays) {
  std::mt19937 rng(3);
  TriangleMesh holed = icosphere(1, 4);
  holed.triangles.erase(holed.triangles.begin() + 10, holed.triangles.begin() + 20);
  TriangleMesh turned_faces = icosphere(1, 3);
  for (const int t : {3, 50, 51})
    std::swap(turned_faces.triangles[std::size_t(t)][0], turned_faces.triangles[std::size_t(t)][1]);
  TriangleMesh apart;  // six faces, each with its own vertices
  for (const auto& t : box_mesh({-1, -1, -1}, {1, 1, 1}).triangles) {
    for (const int v : t)
      apart.vertices.push_back(box_mesh({-1, -1, -1}, {1, 1, 1}).vertices[std::size_t(v)]);
    const auto n = int(apart.vertices.size());
    apart.triangles.push_back({n - 3, n - 2, n - 1});
  }
  const TriangleMesh sphere = icosphere(1, 4);
  const TriangleMesh core = icosphere(0.5, 2);
  TriangleMesh beside = sphere;
  place(beside, {.translation = {1, 0.3, 0.2}});
  const std::tuple<const char*, TriangleMesh, double> meshes[]{
      {"sphere", sphere, 1},
      {"torus", torus(0.7, 0.25, 16, 8), 1},
      {"two overlapping shells", joined(sphere, beside), 1},
      {"nested shells", joined(sphere, core), 1},
      {"cavity", joined(sphere, turned_inside_out(core)), 1},
      {"flipped", turned_inside_out(sphere), -1},
      {"sphere with a hole", holed, 1},
      {"flipped sphere with a hole", turned_inside_out(holed), -1},
      {"sphere with turned faces", turned_faces, 1},
      {"box of unjoined triangles", apart, 1}};
  for (const auto& [name, original, orientation] : meshes) {
    SCOPED_TRACE(name);
    TriangleMesh mesh = original;
    place(mesh, {.axis = random_vector(rng),
                 .degrees = 360 * random_vector(rng)[0],
                 .translation = 0.2 * random_vector(rng)});
    const SampleGrid grid{.origin = Vec3::Constant(-2), .cell_size = 0.5, .cells = {9, 8, 8}};
    EXPECT_GT(compare_with_winding(mesh, orientation, grid), 9 * 8 * 8 * 64 * 98 / 100);
  }
}

TEST(MeshFill, LinesThroughVerticesAndEdgesCountOnce) {
  // vertices, edges and faces of the octahedron pass through samples
  TriangleMesh mesh{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                    {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  const SampleGrid grid{.origin = Vec3::Constant(-1.03125), .cell_size = 0.25, .cells = {9, 9, 9}};
  ASSERT_EQ(grid.sample(0, 0)[0], -1);
  const InsideSamples samples = find_inside(mesh, 8, 1, grid);
  int strictly_inside = 0;
  for (std::size_t cell = 0; cell < grid.cell_count(); ++cell)
    for (int bit = 0; bit < 64; ++bit) {
      const double norm = grid.sample(cell, bit).lpNorm<1>();
      if (norm == 1) continue;  // on the surface
      strictly_inside += norm < 1 ? 1 : 0;
      EXPECT_EQ(samples.masks[cell] >> bit & 1, norm < 1 ? 1U : 0U) << grid.sample(cell, bit).transpose();
    }
  EXPECT_EQ(strictly_inside, 4991);  // 1 + sum of 4 r^2 + 2 for r = 1 to 15
  EXPECT_EQ(samples.reversed + samples.overlapping, 0);
}

TEST(MeshFill, OfABoxIsExact) {
  const MeshFill whole = fill_mesh(box_mesh({0.3, 0, -1}, {1.3, 0.5, 2}), {.cell_size = 0.25});
  EXPECT_EQ(whole.voxels.size(), (std::array<int, 3>{4, 2, 12}));
  EXPECT_EQ(whole.voxels.count(), 96U);
  EXPECT_EQ(whole.contents, std::vector<CellContent>{CellContent{PartFill{}}});
  EXPECT_LT((whole.origin - Vec3(0.3, 0, -1)).norm(), 1e-15);

  const MeshFill shifted =
      fill_mesh(box_mesh({0, 0, 0}, {1, 1, 1}), {.cell_size = 0.25, .offset = {0.5, 7, -3}});
  EXPECT_EQ(shifted.voxels.size(), (std::array<int, 3>{5, 4, 4}));
  EXPECT_LT((shifted.origin - Vec3(-0.125, 0, 0)).norm(), 1e-15);
  ASSERT_EQ(shifted.contents.size(), 3U);
  const CellFill& lower = shifted.contents[shifted.content_of[0]].at(0).fill;
  for (unsigned c = 0; c < 8; ++c) {
    EXPECT_EQ(lower.octant[c], c & 1 ? 1.0F : 0.0F);
    EXPECT_EQ(lower.corner[c],
              c & 1 ? 0.75F : 0.25F);  // 2 times the integral of x, or 1 - x, over its upper half
  }
  const auto [mass, moment] = mass_moment(shifted);
  EXPECT_EQ(mass, 1);
  EXPECT_LT((moment - Vec3(0.5, 0.5, 0.5)).norm(), 1e-7);
}

TEST(MeshFill, KeepsTheVolumeWhereFacesAreParallelToTheLattice) {
  for (const double width : {5.02, 5.1, 5.13, 5.2}) {
    const Vec3 upper(width, 3.07, 4.31);
    const MeshReport report = fill_mesh(box_mesh({0, 0, 0}, upper), {.cell_size = 1}).reports.at(0);
    EXPECT_NEAR(report.true_volume, upper.prod(), 1e-12);
    EXPECT_NEAR(report.filled_volume, report.true_volume, 1e-3 * report.true_volume) << width;
  }
}

TEST(MeshFill, CornersAndOctantsHaveTheSameMean) {
  TriangleMesh mesh = torus(1, 0.4, 60, 30);
  place(mesh, {.axis = {1, 2, 3}, .degrees = 40});
  const MeshFill fill = fill_mesh(mesh, {.cell_size = 0.2});
  int partial = 0;
  double corners = 0;
  for_each_cell(fill, [&](const Vec3&, const CellContent& content) {
    ASSERT_EQ(content.size(), 1U);
    const CellFill& of_cell = content[0].fill;
    double mean = 0;
    for (const float c : of_cell.corner) mean += double(c) / 8;
    for (const float o : of_cell.octant) EXPECT_TRUE(o >= 0 && o <= 1 && o * 8 == std::floor(o * 8)) << o;
    EXPECT_GE(of_cell.share(), 1.0F / 64);
    EXPECT_NEAR(mean, double(of_cell.share()), 1e-6);
    partial += of_cell.share() < 1 ? 1 : 0;
    corners += mean;
  });
  EXPECT_GT(partial, 300);
  const double volume = fill.reports[0].filled_volume / std::pow(fill.cell_size, 3);
  EXPECT_NEAR(corners, volume, 1e-5 * volume);
  const auto [mass, moment] = mass_moment(fill);
  EXPECT_LT((moment / mass).norm(), 2e-3);
  for (std::size_t c = 0; c < fill.contents.size(); ++c)
    for (std::size_t d = 0; d < c; ++d) EXPECT_NE(fill.contents[c], fill.contents[d]);
}

TEST(MeshFill, ACellIsThereIfASampleIsInside) {
  // a nub of a quarter by half by half a cell: four samples
  const TriangleMesh mesh = joined(box_mesh({0, 0, 0}, {2, 1, 1}), box_mesh({2, 0, 0}, {2.25, 0.5, 0.5}));
  const MeshFill fill = fill_mesh(mesh, {.cell_size = 1, .offset = {0.375, 0, 0}});
  EXPECT_EQ(fill.voxels.count(), 3U);
  const CellFill& nub = fill.contents[fill.content_of[3]].at(0).fill;
  EXPECT_EQ(nub.octant, (std::array<float, 8>{0.5F, 0, 0, 0, 0, 0, 0, 0}));
  // along x by 7 and 1 eighths, along y and z by (7 + 5) / 8 and (1 + 3) / 8 samples
  constexpr float near = 7, far = 1, sample = 1.0F / 64;
  EXPECT_EQ(nub.corner,
            (std::array<float, 8>{near * 2.25F * sample, far * 2.25F * sample, near * 0.75F * sample,
                                  far * 0.75F * sample, near * 0.75F * sample, far * 0.75F * sample,
                                  near * 0.25F * sample, far * 0.25F * sample}));
  EXPECT_EQ(mass_moment(fill).first, 2 + 1.0 / 16);
}

TEST(MeshFill, AStaircaseIsFullWhereCentresAreInside) {
  const MeshFill fill = fill_mesh(icosphere(1, 20), {.cell_size = 0.2, .mode = FillMode::staircase});
  ASSERT_EQ(fill.voxels.size(), (std::array<int, 3>{10, 10, 10}));
  EXPECT_EQ(fill.contents.size(), 1U);
  int compared = 0;
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 10; ++j)
      for (int i = 0; i < 10; ++i) {
        const double r = 0.2 * (Vec3(i, j, k) - Vec3::Constant(4.5)).norm();
        if (std::abs(r - 1) < 0.005) continue;  // within the triangles' height
        ++compared;
        EXPECT_EQ(fill.voxels.at(i, j, k), r < 1) << i << j << k;
      }
  EXPECT_GT(compared, 900);
}

TEST(MeshFill, LaterPartsHaveTheSpaceThatTheyShare) {
  const MeshFill fill =
      fill_meshes({{box_mesh({0, 0, 0}, {4, 1, 1}), 2, "bar"}, {box_mesh({1.5, 0, 0}, {3, 1, 1}), 1, "core"}},
                  {.cell_size = 1});
  EXPECT_EQ(fill.voxels.count(), 4U);
  EXPECT_NEAR(mass_moment(fill, 1).first, 1.5, 1e-6);
  EXPECT_NEAR(mass_moment(fill, 2).first, 2.5, 1e-6);
  EXPECT_NEAR(mass_moment(fill).second[0], 8, 1e-5);
  EXPECT_NEAR(fill.reports[0].hidden_volume, 1.5, 1e-12);
  EXPECT_EQ(fill.reports[1].hidden_volume, 0);
  EXPECT_THAT(fill.reports[0].notes(),
              ::testing::ElementsAre(HasSubstr("38 percent of the volume belongs to parts")));
  const CellContent& shared = fill.contents[fill.content_of[1]];
  ASSERT_EQ(shared.size(), 2U);
  EXPECT_EQ(shared[0].part, 1);
  EXPECT_EQ(shared[1].part, 2);
  for (unsigned c = 0; c < 8; ++c) {
    EXPECT_EQ(shared[0].fill.octant[c], c & 1 ? 1.0F : 0.0F);
    EXPECT_EQ(shared[0].fill.octant[c] + shared[1].fill.octant[c], 1);
    EXPECT_EQ(shared[0].fill.corner[c] + shared[1].fill.corner[c], 1);
  }
}

TEST(MeshFill, OpeningsAreRefusedWhereInsideHasNoMeaning) {
  const auto without_a_cap = [](double degrees) {
    TriangleMesh mesh = icosphere(1, 30);
    std::erase_if(mesh.triangles, [&](const std::array<int, 3>& t) {
      const Vec3 middle = mesh.vertices[std::size_t(t[0])] + mesh.vertices[std::size_t(t[1])] +
                          mesh.vertices[std::size_t(t[2])];
      return middle.normalized().z() > std::cos(degrees * std::numbers::pi / 180);
    });
    return mesh;
  };
  // what is undecided goes with the cube of a hole's radius
  const MeshReport small = fill_mesh(without_a_cap(12), {.cell_size = 0.05}).reports.at(0);
  const MeshReport larger = fill_mesh(without_a_cap(20), {.cell_size = 0.05}).reports.at(0);
  const auto cube = [](double degrees) { return std::pow(std::sin(degrees * std::numbers::pi / 180), 3); };
  EXPECT_NEAR(small.undecided / cube(12), 1.17, 0.15);
  EXPECT_NEAR(larger.undecided / cube(20), 1.17, 0.15);
  EXPECT_NEAR(small.filled_volume, 4.18, 0.02);
  EXPECT_THAT(small.notes().at(0), HasSubstr("of its edges have no partner"));
  try {
    fill_mesh(without_a_cap(60), {.cell_size = 0.1}, "cup.obj");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("cup.obj: has openings so large that inside has no meaning"));
  }
}

TEST(MeshFill, TooManyCellsAreRefused) {
  for (const double h : {1e-5, 1e-300}) try {
      fill_mesh(icosphere(1, 5), {.cell_size = h}, "ball.obj");
      ADD_FAILURE();
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::StartsWith("ball.obj: cells of 1e-"));
    }
}

/// Found by the fuzzer: its vertices become one another by rounding.
TEST(MeshFill, AMeshFarFromTheOriginIsRefused) {
  for (const double far : {1e12, 1e300}) try {
      TriangleMesh ball = icosphere(1, 5);
      for (Vec3& x : ball.vertices) x[0] += far;
      fill_mesh(ball, {.cell_size = 0.3}, "ball.obj");
      ADD_FAILURE();
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("m from the origin, where cells of 0.3 m are lost in rounding"));
    }
}

}  // namespace
}  // namespace mss
