#include "tests/fuzz/seeds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <regex>

#include "core/mesh/shapes.hpp"
#include "experiments/io/output.hpp"

namespace mss::fuzz {

namespace {

namespace fs = std::filesystem;

/// The same box in cells as large as divide it, if it has many: an input should take a millisecond.
std::string in_larger_cells(std::string scene) {
  static const std::regex cells(R"(cells = \[(\d+), (\d+), (\d+)\])"), size(R"(cell_size = ([0-9.]+))");
  std::smatch n, h;
  if (!std::regex_search(scene, n, cells)) return scene;
  const std::array<int, 3> count{std::stoi(n[1]), std::stoi(n[2]), std::stoi(n[3])};
  const int divisor = std::gcd(count[0], std::gcd(count[1], count[2]));
  if (divisor == 1 || count[0] * count[1] * count[2] < 64) return scene;
  scene.replace(
      std::size_t(n.position()), std::size_t(n.length()),
      fmt::format("cells = [{}, {}, {}]", count[0] / divisor, count[1] / divisor, count[2] / divisor));
  if (std::regex_search(scene, h, size))
    scene.replace(std::size_t(h.position()), std::size_t(h.length()),
                  fmt::format("cell_size = {}", std::stod(h[1]) * divisor));
  return scene;
}

/// Meshes lie beside the scene, and take few cells.
std::string with_small_mesh(const std::string& scene) {
  static const std::regex folder("\"meshes/"), across(R"(cells_across = \d+)");
  return std::regex_replace(std::regex_replace(scene, folder, "\""), across, "cells_across = 4");
}

std::string obj_of(const TriangleMesh& mesh) {
  std::string text = "# a comment\no body\n";
  for (const Vec3& x : mesh.vertices) text += fmt::format("v {:.6g} {:.6g} {:.6g}\n", x[0], x[1], x[2]);
  for (const auto& [a, b, c] : mesh.triangles) text += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
  return text;
}

template <class Number>
void put(std::string& bytes, Number number, bool big_endian = false) {
  auto raw = std::bit_cast<std::array<char, sizeof(Number)>>(number);
  if (big_endian) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

std::string stl_text_of(const TriangleMesh& mesh) {
  std::string text = "solid body\n";
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const Vec3& x : mesh.corners(t))
      text += fmt::format("   vertex {:.6g} {:.6g} {:.6g}\n", x[0], x[1], x[2]);
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid body\n";
}

std::string stl_binary_of(const TriangleMesh& mesh) {
  std::string bytes(80, ' ');
  put(bytes, std::uint32_t(mesh.triangles.size()));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int axis = 0; axis < 3; ++axis) put(bytes, 0.0F);
    for (const Vec3& x : mesh.corners(t))
      for (int axis = 0; axis < 3; ++axis) put(bytes, float(x[axis]));
    put(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string ply_head(const std::string& format, const TriangleMesh& mesh) {
  return fmt::format(
      "ply\nformat {} 1.0\ncomment a body\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      format, mesh.vertices.size(), mesh.triangles.size());
}

std::string ply_text_of(const TriangleMesh& mesh) {
  std::string text = ply_head("ascii", mesh);
  for (const Vec3& x : mesh.vertices) text += fmt::format("{:.6g} {:.6g} {:.6g}\n", x[0], x[1], x[2]);
  for (const auto& [a, b, c] : mesh.triangles) text += fmt::format("3 {} {} {}\n", a, b, c);
  return text;
}

std::string ply_binary_of(const TriangleMesh& mesh, bool big_endian) {
  std::string bytes = ply_head(big_endian ? "binary_big_endian" : "binary_little_endian", mesh);
  for (const Vec3& x : mesh.vertices)
    for (int axis = 0; axis < 3; ++axis) put(bytes, float(x[axis]), big_endian);
  for (const auto& triangle : mesh.triangles) {
    bytes += '\3';
    for (const int corner : triangle) put(bytes, std::int32_t(corner), big_endian);
  }
  return bytes;
}

void add_meshes(Seeds& seeds) {
  const TriangleMesh ball = icosphere(1, 2), box = box_mesh({0, 0, 0}, {1, 0.5, 0.25}),
                     ring = torus(1, 0.4, 10, 6), two = joined(box, box_mesh({2, 0, 0}, {3, 1, 1}));
  for (const TriangleMesh& mesh : {ball, box, ring, two, turned_inside_out(box)}) {
    seeds.texts[std::size_t(Kind::obj)].push_back(obj_of(mesh));
    seeds.texts[std::size_t(Kind::stl)].push_back(stl_text_of(mesh));
    seeds.texts[std::size_t(Kind::stl)].push_back(stl_binary_of(mesh));
    seeds.texts[std::size_t(Kind::ply)].push_back(ply_text_of(mesh));
    seeds.texts[std::size_t(Kind::ply)].push_back(ply_binary_of(mesh, false));
    seeds.texts[std::size_t(Kind::ply)].push_back(ply_binary_of(mesh, true));
  }
  seeds.texts[std::size_t(Kind::obj)].push_back(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvt 0 0\nvn 0 0 1\n"
      "f 4 3 2 1\nf 5 6 7 8\nf 1/1/1 2/1/1 6/1/1 5/1/1\nf 2//1 3//1 7//1 6//1\nf -6 -5 -1 -2\nf 4 1 5 8\n");
  seeds.companions["sphere.obj"] = obj_of(ball);
  seeds.companions["torus.obj"] = obj_of(ring);
  seeds.companions["bear.obj"] = obj_of(two);
  seeds.companions["box.stl"] = stl_binary_of(box);
  seeds.companions["ball.ply"] = ply_binary_of(ball, false);
}

}  // namespace

Seeds make_seeds(const fs::path& scenes) {
  Seeds seeds;
  std::vector<fs::path> files(fs::directory_iterator(scenes), fs::directory_iterator{});
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    if (file.extension() == ".toml")
      seeds.texts[std::size_t(Kind::scene)].push_back(with_small_mesh(in_larger_cells(read_file(file))));
    if (file.extension() == ".txt") {
      seeds.companions[file.filename().string()] = read_file(file);
      seeds.texts[std::size_t(Kind::voxels)].push_back(read_file(file));
    }
  }
  for (const char* mesh : {"bar.obj", "bracket_arm.obj", "bracket_foot.obj"})
    seeds.companions[mesh] = read_file(scenes / "meshes" / mesh);
  for (const char* text : {"#\n", "##A\n5#A\n\n.#A\n1#.\n", "AA9\n", "##\n##\n\n##\n##\n"})
    seeds.texts[std::size_t(Kind::voxels)].emplace_back(text);
  seeds.companions["parts.txt"] = "##A\n5#A\n\n.#A\n1#.\n";
  add_meshes(seeds);
  return seeds;
}

}  // namespace mss::fuzz
