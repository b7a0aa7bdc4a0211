// Files of meshes, sound and damaged: each ends in a mesh, a body, or one sentence that names the file.
#include "core/mesh/read_mesh.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <numbers>

#include "core/base/error.hpp"
#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/shapes.hpp"
#include "tests/core/scene/scene_texts.hpp"

#if MSS_SANITIZED
/// assimp leaks two objects where it throws.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libassimp"; }
#endif

namespace mss {
namespace {

using ::testing::HasSubstr;

/// The bytes of numbers, as this machine has them: little endian.
template <class... Numbers>
std::string bytes(Numbers... numbers) {
  std::string all;
  (all.append(reinterpret_cast<const char*>(&numbers), sizeof(numbers)), ...);
  return all;
}

std::string binary_stl(const TriangleMesh& mesh, std::uint32_t claimed) {
  std::string content(80, ' ');
  content += bytes(claimed);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    content += bytes(0.0F, 0.0F, 0.0F);
    for (const Vec3& x : mesh.corners(t)) content += bytes(float(x.x()), float(x.y()), float(x.z()));
    content += bytes(std::uint16_t(0));
  }
  return content;
}

std::string text_stl(const TriangleMesh& mesh) {
  std::string content = "solid body\n";
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    content += "facet normal 0 0 0\nouter loop\n";
    for (const Vec3& x : mesh.corners(t)) content += fmt::format("vertex {} {} {}\n", x.x(), x.y(), x.z());
    content += "endloop\nendfacet\n";
  }
  return content + "endsolid body\n";
}

std::string obj(const TriangleMesh& mesh) {
  std::string content;
  for (const Vec3& x : mesh.vertices) content += fmt::format("v {} {} {}\n", x.x(), x.y(), x.z());
  for (const auto& t : mesh.triangles) content += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return content;
}

std::string ply_head(const std::string& format, std::uint64_t vertices, std::uint64_t faces,
                     const std::string& count_type = "uchar") {
  return fmt::format(
      "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list {} int vertex_indices\nend_header\n",
      format, vertices, faces, count_type);
}

std::string text_ply(const TriangleMesh& mesh, std::uint64_t vertices, std::uint64_t faces) {
  std::string content = ply_head("ascii", vertices, faces);
  for (const Vec3& x : mesh.vertices) content += fmt::format("{} {} {}\n", x.x(), x.y(), x.z());
  for (const auto& t : mesh.triangles) content += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
  return content;
}

std::string binary_ply(const TriangleMesh& mesh, std::uint64_t vertices, std::uint64_t faces) {
  std::string content = ply_head("binary_little_endian", vertices, faces);
  for (const Vec3& x : mesh.vertices) content += bytes(float(x.x()), float(x.y()), float(x.z()));
  for (const auto& t : mesh.triangles) content += bytes(std::uint8_t(3)) + bytes(t[0], t[1], t[2]);
  return content;
}

/// A box of 1 x 2 x 3 m.
TriangleMesh box() { return box_mesh({0, 0, 0}, {1, 2, 3}); }

TEST(ReadMesh, TheFormatsSayTheSame) {
  const testing::SceneFolder folder;
  const TriangleMesh mesh = box();
  const std::pair<const char*, std::string> files[]{
      {"a.obj", obj(mesh)},
      {"a.OBJ", "mtllib none.mtl\no box\nusemtl red\n" + obj(mesh)},
      {"b.stl", binary_stl(mesh, 12)},
      {"c.stl", text_stl(mesh)},
      {"d.ply", text_ply(mesh, 8, 12)},
      {"e.ply", binary_ply(mesh, 8, 12)}};
  for (const auto& [name, content] : files) {
    const TriangleMesh read = read_mesh(folder.write(name, content));
    EXPECT_EQ(read.vertices.size(), 8U) << name;
    EXPECT_EQ(read.triangles.size(), 12U) << name;
    EXPECT_TRUE(open_edges(read).empty()) << name;
    EXPECT_NEAR(enclosed_volume(read), 6, 1e-6) << name;
  }
}

TEST(ReadMesh, WrittenIsRead) {
  const testing::SceneFolder folder;
  const TriangleMesh mesh = icosphere(0.3, 7);
  write_obj(folder.path() / "sphere.obj", mesh);
  const TriangleMesh read = read_mesh(folder.path() / "sphere.obj");
  EXPECT_EQ(read.vertices.size(), mesh.vertices.size());
  EXPECT_NEAR(enclosed_volume(read), enclosed_volume(mesh), 1e-7 * enclosed_volume(mesh));
  EXPECT_THROW(write_obj(folder.path() / "none" / "sphere.obj", mesh), InputError);
}

/// A file and what comes of it: a volume [m^3] of cells of .25 m and a note, or a complaint.
struct Damaged {
  std::string name;
  std::string content;
  std::string says;
  double volume = 0;  ///< 0: refused
};

std::vector<Damaged> damaged_text_files() {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nv 1 0 3\nv 1 2 3\nv 0 2 3\n";
  const std::string quads = "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  TriangleMesh no_face = icosphere(1, 12);
  no_face.triangles.resize(no_face.triangles.size() - 3);
  TriangleMesh zero = box();
  zero.triangles.push_back({0, 0, 1});
  zero.triangles.push_back({0, 1, 1});
  TriangleMesh turned = icosphere(1, 12);
  std::swap(turned.triangles[5][0], turned.triangles[5][1]);
  TriangleMesh open_box = box();
  open_box.triangles.resize(10);
  TriangleMesh far_box = box_mesh({7, 0, 0}, {8, 2, 3});
  const double sphere = enclosed_volume(icosphere(1, 12));
  return {
      {"quads.obj", vertices + quads, "", 6},
      {"relative.obj", vertices + "f -8 -5 -6 -7\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n",
       "", 6},
      {"groups.obj", vertices + "o a\n" + quads.substr(0, 20) + "o b\n" + quads.substr(20), "", 6},
      {"quad_on_a_line.obj", vertices + quads + "f 1 2 2 1\n", "no area", 6},
      {"seven_corners.obj", vertices + "v .5 0 0\nv .5 2 0\nv 1 1 0\nf 1 4 10 3 11 2 9\n" + quads.substr(10),
       "9 of its edges have no partner", 6},
      {"small_hole.obj", obj(no_face), "of its edges have no partner", sphere},
      {"zero_faces.obj", obj(zero), "2 of its triangles have no area", 6},
      {"two_shells.obj", obj(joined(box(), far_box)), "2 shells", 12},
      {"overlapping.obj", obj(joined(box(), box_mesh({0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}))), "more than once",
       6.5},
      {"cavity.obj", obj(joined(box(), turned_inside_out(box_mesh({.25, .5, .5}, {.75, 1.5, 2.5})))),
       "2 shells", 5},
      {"inside_out.obj", obj(turned_inside_out(box())), "turned around", 6},
      {"one_face_turned.obj", obj(turned), "no partner", sphere},
      {"one_shell_inside_out.obj", obj(joined(box(), turned_inside_out(box_mesh({7, 0, 0}, {8, 1, 1})))),
       "inside out"},
      {"open_box.obj", obj(open_box), "4 of its edges have no partner"},
      {"flat.obj", vertices + "f 1 2 3 4\n", "encloses no volume"},
      {"flat_twice.obj", vertices + "f 1 2 3 4\nf 4 3 2 1\n", "encloses no volume"},
      {"empty.obj", "", "is empty"},
      {"text.obj", "This is a letter, dear reader.\n", ""},
      {"text.stl", "This is a letter, dear reader.\n", "too short"},
      {"long_text.stl", std::string(500, 'x'), "says that it has"},
      {"text.ply", "This is a letter, dear reader.\n", "begin with 'ply'"},
      {"solid_text.stl", "solid as a rock\n", ""},
      {"nothing.stl", "solid nothing\nendsolid nothing\n", ""},
      {"cut_text.stl", text_stl(box()).substr(0, 200), ""},
      {"nan.obj", "v nan 0 0\n" + vertices + quads + "f 1 2 3\n", "vertex at (nan"},
      {"infinite.obj", "v inf 0 0\n" + vertices + quads + "f 1 2 3\n", "vertex at (inf"},
      {"overflow.obj", "v 1e300 0 0\n" + vertices + quads + "f 1 2 3\n", "vertex at ("},
      {"too_far.obj", "v 1e17 0 0\n" + vertices + quads + "f 1 2 3\n", "at most 1e15"},
      {"far.obj", "v 1e9 0 0\n" + vertices + quads + "f 1 2 3\n", "million particles"},
      {"index.obj", vertices + quads + "f 1 2 99\n", ""},
      {"zero_index.obj", vertices + quads + "f 0 1 2\n", ""},
      {"negative_index.obj", vertices + quads + "f -1 -2 -99\n", ""},
      {"huge_index.obj", vertices + quads + "f 1 2 99999999999999999999\n", ""},
      {"points.obj", vertices + "p 1 2 3\n", ""},
      {"lines.obj", vertices + "l 1 2 3\n", "no triangles"},
      {"vertices.obj", vertices, ""},
      {"mesh.abc", vertices + quads, "ends in .obj, .stl or .ply"},
      {"mesh", vertices + quads, "ends in .obj, .stl or .ply"},
      {"Körper ä.obj", vertices + quads, "", 6},
      {"Körper leer.obj", "", "is empty"},
      {"thin.obj", obj(box_mesh({0, 0, 0}, {1, 1, 1e-6})), "too thin"},
  };
}

std::vector<Damaged> damaged_binary_files() {
  const TriangleMesh mesh = box();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  TriangleMesh not_finite = mesh;
  not_finite.vertices[3].x() = nan;
  TriangleMesh wrong = mesh;
  wrong.triangles[3][1] = 99;
  TriangleMesh negative = mesh;
  negative.triangles[3][1] = -5;
  const TriangleMesh cloud{mesh.vertices, {}};
  const std::string list_of_ints =
      ply_head("binary_little_endian", 8, 1, "uint") +
      binary_ply(cloud, 8, 0).substr(ply_head("binary_little_endian", 8, 0).size());
  std::string quad_out_of_range = binary_ply(mesh, 8, 13);
  quad_out_of_range += bytes(std::uint8_t(4)) + bytes(0, 1, 2, 1 << 30);
  return {
      {"sound.stl", binary_stl(mesh, 12), "", 6},
      {"false_count.stl", binary_stl(mesh, 13), "says that it has 13 triangles, but 12 fit"},
      {"huge_count.stl", binary_stl(mesh, 4294967295U), "says that it has 4294967295"},
      {"cut.stl", binary_stl(mesh, 12).substr(0, 300), "says that it has 12 triangles, but 4 fit"},
      {"none.stl", binary_stl({}, 0), ""},
      {"head.stl", std::string(70, ' '), "too short"},
      {"solid_binary.stl", "solid" + binary_stl(mesh, 40).substr(5), "says that it has 40"},
      {"nan.stl", binary_stl(not_finite, 12), "vertex at (nan"},
      {"huge_vertices.ply", binary_ply(mesh, 4000000000, 12), "element 'vertex'"},
      {"huge_faces.ply", binary_ply(mesh, 8, 4000000000), "element 'face'"},
      {"huger_faces.ply", text_ply(mesh, 8, 18446744073709551615U), "element 'face'"},
      {"huge_text.ply", text_ply(mesh, 4000000000, 12), "element 'vertex'"},
      {"huge_polygon.ply", list_of_ints + bytes(std::uint32_t(4000000000U), 0, 1, 2), "element 'face'"},
      {"huge_text_polygon.ply", text_ply(cloud, 8, 1) + "4000000000 0 1 2\n", "element 'face'"},
      {"cut.ply", binary_ply(mesh, 8, 12).substr(0, 300), "element 'face'"},
      {"head.ply", ply_head("ascii", 8, 12).substr(0, 60), "within its head"},
      {"count.ply", "ply\nformat ascii 1.0\nelement vertex many\nend_header\n", "'many' as the number"},
      {"type.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n1\n",
       "unknown type 'quad'"},
      {"empty_elements.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000\nend_header\n",
       "without properties"},
      {"index.ply", binary_ply(wrong, 8, 12), "vertex 99, but 8 vertices"},
      {"negative.ply", binary_ply(negative, 8, 12), "vertex -5, but 8 vertices"},
      {"quad.ply", quad_out_of_range, "vertex 1073741824, but 8"},
      {"points.ply", text_ply(cloud, 8, 0), ""},
  };
}

void expect_sentence(const std::string& message, const Damaged& file) {
  EXPECT_THAT(message, HasSubstr(file.name + ": "));
  EXPECT_THAT(message, HasSubstr(file.says)) << file.name;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_NE(message.back(), '.') << message;
  EXPECT_LT(message.size(), 600U) << message;
}

TEST(ReadMesh, DamagedFilesEndInASentenceOrABody) {
  const testing::SceneFolder folder;
  std::vector<Damaged> files = damaged_text_files();
  for (const Damaged& file : damaged_binary_files()) files.push_back(file);
  EXPECT_GT(files.size(), 40U);
  for (const Damaged& file : files) {
    const std::filesystem::path path = folder.write(file.name, file.content);
    try {
      const MeshFill fill = fill_mesh(read_mesh(path), {.cell_size = 0.25}, path.string());
      const MeshReport& report = fill.reports.at(0);
      std::string notes;
      for (const std::string& note : report.notes()) notes += note + "; ";
      EXPECT_NEAR(report.filled_volume, file.volume, 1e-2 * file.volume) << file.name << ": " << notes;
      EXPECT_THAT(notes, HasSubstr(file.says)) << file.name;
      EXPECT_EQ(notes.empty(), file.says.empty()) << file.name << notes;
    } catch (const InputError& error) {
      EXPECT_EQ(file.volume, 0) << error.what();
      expect_sentence(error.what(), file);
    }
  }
}

TEST(ReadMesh, WhatIsNoFile) {
  const testing::SceneFolder folder;
  for (const std::string name : {"none.obj", "folder.obj"}) {
    if (name == "folder.obj") std::filesystem::create_directory(folder.path() / name);
    try {
      read_mesh(folder.path() / name);
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      expect_sentence(error.what(), {name, "", "cannot be read"});
    }
  }
}

}  // namespace
}  // namespace mss
