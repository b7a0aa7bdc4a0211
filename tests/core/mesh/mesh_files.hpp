#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>

#include "core/mesh/triangle_mesh.hpp"

// Files of meshes, as programs write them.

namespace mss::testing {

/// The bytes of numbers, as this machine has them: little endian.
template <class... Numbers>
std::string bytes(Numbers... numbers) {
  std::string all;
  (all.append(reinterpret_cast<const char*>(&numbers), sizeof(numbers)), ...);
  return all;
}

inline std::string binary_stl(const TriangleMesh& mesh, std::uint32_t claimed) {
  std::string content(80, ' ');
  content += bytes(claimed);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    content += bytes(0.0F, 0.0F, 0.0F);
    for (const Vec3& x : mesh.corners(t)) content += bytes(float(x.x()), float(x.y()), float(x.z()));
    content += bytes(std::uint16_t(0));
  }
  return content;
}

inline std::string text_stl(const TriangleMesh& mesh) {
  std::string content = "solid body\n";
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    content += "facet normal 0 0 0\nouter loop\n";
    for (const Vec3& x : mesh.corners(t)) content += fmt::format("vertex {} {} {}\n", x.x(), x.y(), x.z());
    content += "endloop\nendfacet\n";
  }
  return content + "endsolid body\n";
}

inline std::string obj(const TriangleMesh& mesh) {
  std::string content;
  for (const Vec3& x : mesh.vertices) content += fmt::format("v {} {} {}\n", x.x(), x.y(), x.z());
  for (const auto& t : mesh.triangles) content += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return content;
}

inline std::string ply_head(const std::string& format, std::uint64_t vertices, std::uint64_t faces,
                            const std::string& count_type = "uchar") {
  return fmt::format(
      "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list {} int vertex_indices\nend_header\n",
      format, vertices, faces, count_type);
}

inline std::string text_ply(const TriangleMesh& mesh, std::uint64_t vertices, std::uint64_t faces) {
  std::string content = ply_head("ascii", vertices, faces);
  for (const Vec3& x : mesh.vertices) content += fmt::format("{} {} {}\n", x.x(), x.y(), x.z());
  for (const auto& t : mesh.triangles) content += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
  return content;
}

inline std::string binary_ply(const TriangleMesh& mesh, std::uint64_t vertices, std::uint64_t faces) {
  std::string content = ply_head("binary_little_endian", vertices, faces);
  for (const Vec3& x : mesh.vertices) content += bytes(float(x.x()), float(x.y()), float(x.z()));
  for (const auto& t : mesh.triangles) content += bytes(std::uint8_t(3)) + bytes(t[0], t[1], t[2]);
  return content;
}

}  // namespace mss::testing
