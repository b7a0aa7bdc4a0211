// A surface in cells: where its vertices are, and what their forces do.
#include "core/mesh/embedded_surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/shapes.hpp"

namespace mss {
namespace {

/// A sphere in cells that do not hold all of its vertices.
struct Embedded {
  TriangleMesh mesh = icosphere(1, 8);
  MeshFill fill = fill_mesh(mesh, {.cell_size = 0.23, .offset = {0.3, 0.7, 0.1}});
  Lattice lattice{fill.voxels.nx(), fill.voxels.ny(), fill.voxels.nz()};
  EmbeddedSurface surface{mesh, fill.voxels, fill.cell_size, fill.origin};

  /// Calls visit(site, rest position) for every site.
  template <class Visit>
  void for_each_site(Visit&& visit) const {
    for (int k = 0; k <= fill.voxels.nz(); ++k)
      for (int j = 0; j <= fill.voxels.ny(); ++j)
        for (int i = 0; i <= fill.voxels.nx(); ++i)
          visit(lattice.site(i, j, k), Vec3(fill.origin + fill.cell_size * Vec3(i, j, k)));
  }
  bool has_cell(std::ptrdiff_t site) const {
    const auto [i, j, k] = lattice.coordinates(site);
    return fill.voxels.at(i, j, k);
  }
};

TEST(EmbeddedSurface, ReproducesAffineMaps) {
  const Embedded e;
  Eigen::Matrix3d map;
  map << 1.2, 0.1, -0.3, 0.4, 0.9, 0.2, -0.1, 0.5, 1.1;
  const Vec3 shift(0.3, -2, 5);
  Field<double> x(e.lattice.size);
  e.for_each_site([&](std::ptrdiff_t site, const Vec3& rest) { x.set(site, map * rest + shift); });
  const std::vector<Vec3> positions = e.surface.interpolate(x);
  ASSERT_EQ(positions.size(), e.mesh.vertices.size());
  int outside = 0;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    EXPECT_LT((positions[v] - (map * e.mesh.vertices[v] + shift)).norm(), 1e-13);
    EXPECT_TRUE(e.has_cell(e.surface.site(v)));
    double sum = 0;
    bool extrapolates = false;
    for (const double weight : e.surface.weights(v)) {
      sum += weight;
      extrapolates = extrapolates || weight < -1e-9;
    }
    EXPECT_NEAR(sum, 1, 1e-14);
    outside += extrapolates ? 1 : 0;
  }
  EXPECT_GT(outside, 10);  // vertices whose cell was dropped
  EXPECT_LT(outside, int(positions.size()) / 3);
}

TEST(EmbeddedSurface, TheNearestCellIsTheNearest) {
  const Embedded e;
  const double h = e.fill.cell_size;
  int other_cell = 0;
  for (std::size_t v = 0; v < e.surface.size(); ++v) {
    const auto distance = [&](const Vec3& lower) {
      const Vec3& x = e.mesh.vertices[v];
      return (x - x.cwiseMax(lower).cwiseMin(lower + Vec3::Constant(h))).norm();
    };
    double least = 1e9, own = 1e9;
    e.for_each_site([&](std::ptrdiff_t site, const Vec3& rest) {
      if (!e.has_cell(site)) return;
      least = std::min(least, distance(rest));
      if (site == e.surface.site(v)) own = distance(rest);
    });
    EXPECT_NEAR(own, least, 1e-12);
    other_cell += own > 0.01 * h ? 1 : 0;
  }
  EXPECT_GT(other_cell, 10);
}

template <class Real>
void forces_and_moments_stay(double tolerance) {
  const Embedded e;
  std::mt19937 rng(4);
  std::uniform_real_distribution<> u(-1, 1);
  std::vector<Vec3> forces;
  for (std::size_t v = 0; v < e.surface.size(); ++v) {
    const double fx = u(rng), fy = u(rng);
    forces.emplace_back(fx, fy, u(rng));
  }
  Eigen::Matrix3d map;  // deformed: the vertices are where the weights say
  map << 1.2, 0.1, -0.3, 0.4, 0.9, 0.2, -0.1, 0.5, 1.1;
  Field<Real> x(e.lattice.size), on_particles(e.lattice.size);
  e.for_each_site([&](std::ptrdiff_t site, const Vec3& rest) { x.set(site, map * rest); });
  e.surface.distribute(forces, on_particles);
  const std::vector<Vec3> positions = e.surface.interpolate(x);
  const Vec3 about(3, -4, 7);
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  for (std::size_t v = 0; v < forces.size(); ++v) {
    force += forces[v];
    moment += (positions[v] - about).cross(forces[v]);
  }
  ASSERT_GT(force.norm(), 1);
  ASSERT_GT(moment.norm(), 10);
  e.for_each_site([&](std::ptrdiff_t site, const Vec3&) {
    force -= on_particles.at(site);
    moment -= (x.at(site) - about).cross(on_particles.at(site));
  });
  EXPECT_LT(force.norm(), tolerance);
  EXPECT_LT(moment.norm(), 10 * tolerance);
}

TEST(EmbeddedSurface, ForcesAndMomentsStay) {
  forces_and_moments_stay<double>(1e-12);
  forces_and_moments_stay<float>(1e-4);
}

TEST(EmbeddedSurface, WorkIsTheSameOnBothSides) {
  const Embedded e;
  std::mt19937 rng(5);
  std::uniform_real_distribution<> u(-1, 1);
  Field<double> v(e.lattice.size), f(e.lattice.size);
  e.for_each_site([&](std::ptrdiff_t site, const Vec3&) {
    const double vx = u(rng), vy = u(rng);
    v.set(site, {vx, vy, u(rng)});
  });
  const std::vector<Vec3> forces(e.surface.size(), Vec3(1, 2, 3));
  e.surface.distribute(forces, f);
  double work = 0, magnitude = 0;
  e.for_each_site([&](std::ptrdiff_t site, const Vec3&) {
    work -= v.at(site).dot(f.at(site));
    magnitude += std::abs(v.at(site).dot(f.at(site)));
  });
  for (const Vec3& x : e.surface.interpolate(v)) work += x.dot(Vec3(1, 2, 3));
  EXPECT_GT(magnitude, 100);
  EXPECT_LT(std::abs(work), 1e-13 * magnitude);
}

}  // namespace
}  // namespace mss
