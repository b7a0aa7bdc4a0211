#include "core/mesh/shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "core/base/error.hpp"

namespace mss {

namespace {

TriangleMesh icosahedron() {
  const double g = std::numbers::phi;
  return {{{-1, g, 0},
           {1, g, 0},
           {-1, -g, 0},
           {1, -g, 0},
           {0, -1, g},
           {0, 1, g},
           {0, -1, -g},
           {0, 1, -g},
           {g, 0, -1},
           {g, 0, 1},
           {-g, 0, -1},
           {-g, 0, 1}},
          {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
           {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
           {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
}

}  // namespace

TriangleMesh icosphere(double radius, int divisions) {
  const TriangleMesh coarse = icosahedron();
  TriangleMesh fine;
  for (const auto& face : coarse.triangles) {
    const auto first = int(fine.vertices.size());
    const auto at = [&](int i, int j) { return first + i * (i + 1) / 2 + j; };
    for (int i = 0; i <= divisions; ++i)
      for (int j = 0; j <= i; ++j) {
        // in the order of vertices, so that faces agree on the points of their common edges to the last bit
        std::array<std::pair<int, int>, 3> parts{{{face[0], divisions - i}, {face[1], i - j}, {face[2], j}}};
        std::sort(parts.begin(), parts.end());
        Vec3 x = Vec3::Zero();
        for (const auto& [vertex, weight] : parts) x += weight * coarse.vertices[std::size_t(vertex)];
        fine.vertices.emplace_back(radius * x.normalized());
      }
    for (int i = 0; i < divisions; ++i)
      for (int j = 0; j <= i; ++j) {
        fine.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        if (j < i) fine.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  }
  return merge_identical(fine);
}

TriangleMesh torus(double ring, double tube, int around, int across) {
  TriangleMesh mesh;
  const auto at = [&](int i, int j) { return i % around * across + j % across; };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double a = 2 * std::numbers::pi * i / around;
      const double b = 2 * std::numbers::pi * j / across;
      const double r = ring + tube * std::cos(b);
      mesh.vertices.emplace_back(r * std::cos(a), r * std::sin(a), tube * std::sin(b));
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

TriangleMesh box_mesh(const Vec3& lower, const Vec3& upper) {
  TriangleMesh mesh;
  for (int c = 0; c < 8; ++c)
    mesh.vertices.emplace_back(c & 1 ? upper.x() : lower.x(), c & 2 ? upper.y() : lower.y(),
                               c & 4 ? upper.z() : lower.z());
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

TriangleMesh cylinder_mesh(double radius, double length, int around) {
  TriangleMesh mesh{{{0, 0, -length / 2}, {0, 0, length / 2}}, {}};
  const auto at = [&](int i, int top) { return 2 + 2 * (i % around) + top; };
  for (int i = 0; i < around; ++i) {
    const double angle = 2 * std::numbers::pi * i / around;
    for (const int side : {-1, 1})
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), side * length / 2);
    mesh.triangles.push_back({0, at(i + 1, 0), at(i, 0)});
    mesh.triangles.push_back({1, at(i, 1), at(i + 1, 1)});
    mesh.triangles.push_back({at(i, 0), at(i + 1, 0), at(i + 1, 1)});
    mesh.triangles.push_back({at(i, 0), at(i + 1, 1), at(i, 1)});
  }
  return mesh;
}

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh = a;
  const auto shift = int(a.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) mesh.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  return mesh;
}

TriangleMesh turned_inside_out(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

void write_obj(const std::filesystem::path& file, const TriangleMesh& mesh) {
  std::ofstream out(file);
  for (const Vec3& x : mesh.vertices) out << fmt::format("v {:.9g} {:.9g} {:.9g}\n", x.x(), x.y(), x.z());
  for (const auto& t : mesh.triangles) out << fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  if (!out.flush())
    throw InputError(
        fmt::format("{}: cannot write this mesh file; give a path in an existing folder", file.string()));
}

}  // namespace mss
