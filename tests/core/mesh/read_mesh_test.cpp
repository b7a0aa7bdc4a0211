// Files of meshes, sound and damaged: each ends in a mesh, a body, or one sentence that names the file.
#include "core/mesh/read_mesh.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <numbers>

#include "core/base/error.hpp"
#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/shapes.hpp"
#include "tests/core/mesh/mesh_files.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss {
namespace {

using testing::binary_ply;
using testing::binary_stl;
using testing::bytes;
using ::testing::HasSubstr;
using testing::obj;
using testing::ply_head;
using testing::text_ply;
using testing::text_stl;

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
    const TriangleMesh read = read_mesh(folder.write(name, content)).mesh;
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
  const TriangleMesh read = read_mesh(folder.path() / "sphere.obj").mesh;
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
      {"one_face_turned.obj", obj(turned), "1 of its 2880 triangles faced the other way", sphere},
      {"one_shell_inside_out.obj", obj(joined(box(), turned_inside_out(box_mesh({7, 0, 0}, {8, 1, 1})))),
       "inside out"},
      {"shells_that_cancel.obj", obj(joined(box(), turned_inside_out(far_box))),
       "turn around the shells that are inside out"},
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
      {"huger_faces.ply", text_ply(mesh, 8, 18446744073709551615U), "'18446744073709551615' as the number"},
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
      const MeshOfFile read = read_mesh(path);
      const MeshFill fill = fill_meshes({{.mesh = read.mesh, .name = path.string(), .repairs = read.repairs}},
                                        {.cell_size = 0.25});
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

/// Whether a mesh is the box of 1 x 2 x 3 m, whatever the order of its vertices.
void expect_box(const TriangleMesh& mesh, const std::string& name) {
  EXPECT_EQ(mesh.vertices.size(), 8U) << name;
  EXPECT_TRUE(open_edges(mesh).empty()) << name;
  EXPECT_DOUBLE_EQ(enclosed_volume(mesh), 6) << name;
}

std::string replaced(std::string text, const std::string& old, const std::string& with) {
  for (std::size_t at = text.find(old); at != std::string::npos; at = text.find(old, at + with.size()))
    text.replace(at, old.size(), with);
  return text;
}

TEST(ReadMesh, ObjAsProgramsWriteIt) {
  const testing::SceneFolder folder;
  const std::string plain = obj(box());
  std::string with_textures, backwards, quads = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nv 1 0 3\n";
  for (const Vec3& x : box().vertices)
    with_textures += backwards += fmt::format("v {} {} {} 0.5 0.5 0.5\n", x.x(), x.y(), x.z());
  with_textures = backwards + "vt 0 0\nvn 0 0 1\ns off\n";
  for (const auto& t : box().triangles) {
    with_textures += fmt::format("f {}/1/1 {}//1 {}/1\n", t[0] + 1, t[1] + 1, t[2] + 1);
    backwards += fmt::format("f {} {} {}\n", t[0] - 8, t[1] - 8, t[2] - 8);
  }
  quads += "v 1 2 3\nv 0 2 3\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8";
  const std::pair<const char*, std::string> files[]{
      {"comments.obj", replaced(plain, "\n", " # comment\n")},
      {"near_comments.obj", replaced(plain, "\n", "#f 1 2 3\n")},
      {"windows.obj", replaced(plain, "\n", "\r\n")},
      {"macintosh.obj", replaced(plain, "\n", "\r")},
      {"mark.obj", "\xef\xbb\xbf" + plain},
      {"mark_comment.obj", "\xef\xbb\xbf# written by hand\n" + plain},
      {"continued.obj", replaced(plain, " 3 ", " \\\n 3 ")},
      {"continued_windows.obj", replaced(replaced(plain, "\n", "\r\n"), " 3 ", " \\\r\n3\\\r\n ")},
      {"tabs.obj", replaced(plain, " ", "\t ")},
      {"textures.obj", with_textures},
      {"backwards.obj", backwards},
      {"quads.obj", quads},
      {"bare_points.obj", replaced(plain, "v 0 ", "v .0 ")},
      {"plus.obj", replaced(plain, "v 1 ", "v +1.e0 ")},
      {"faces_first.obj", plain.substr(plain.find('f')) + plain.substr(0, plain.find('f'))}};
  for (const auto& [name, content] : files) {
    const MeshOfFile read = read_mesh(folder.write(name, content));
    expect_box(read.mesh, name);
    EXPECT_TRUE(read.repairs.empty()) << name << read.repairs.front();
  }
}

TEST(ReadMesh, DividesPolygonsThatAreNotConvex) {
  const testing::SceneFolder folder;
  // a prism of height 1 over an L, a star and a comb, clockwise as seen from above at the bottom
  const std::vector<std::pair<double, double>> shapes[]{
      {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
      {{0, 3},
       {-.7, 1},
       {-3, .9},
       {-1.1, -.4},
       {-1.8, -2.4},
       {0, -1.2},
       {1.8, -2.4},
       {1.1, -.4},
       {3, .9},
       {.7, 1}},
      {{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}};
  for (const auto& shape : shapes) {
    const auto n = int(shape.size());
    std::string content, top = "f", bottom = "f", sides;
    double area = 0, perimeter = 0;
    for (int i = 0; i < n; ++i) {
      const auto& [x, y] = shape[std::size_t(i)];
      const auto& [next_x, next_y] = shape[std::size_t(i + 1) % shape.size()];
      area += (x * next_y - y * next_x) / 2;
      perimeter += std::hypot(next_x - x, next_y - y);
      content += fmt::format("v {} {} 0\nv {} {} 1\n", x, y, x, y);
      top += fmt::format(" {}", 2 * i + 2);
      bottom += fmt::format(" {}", 2 * (n - i) - 1);
      const int next = (i + 1) % n;
      sides += fmt::format("f {} {} {} {}\n", 2 * i + 1, 2 * next + 1, 2 * next + 2, 2 * i + 2);
    }
    const TriangleMesh mesh =
        read_mesh(folder.write("prism.obj", fmt::format("{}{}\n{}\n{}", content, top, bottom, sides))).mesh;
    EXPECT_TRUE(open_edges(mesh).empty()) << n;
    EXPECT_NEAR(enclosed_volume(mesh), std::abs(area), 1e-12) << n;
    EXPECT_NEAR(surface_area(mesh), 2 * std::abs(area) + perimeter, 1e-9) << n;  // no triangle covers another
    EXPECT_EQ(zero_faces(mesh), 0U) << n;
    // no triangle lies outside its polygon: cells of an eighth hold what the prism holds
    EXPECT_NEAR(fill_mesh(mesh, {.cell_size = 0.25}).reports.at(0).filled_volume, std::abs(area),
                0.005 * std::abs(area));
  }
}

TEST(ReadMesh, StlIsTextOrBinaryByWhatIsInIt) {
  const testing::SceneFolder folder;
  const std::string text = text_stl(box()), binary = binary_stl(box(), 12);
  const std::pair<const char*, std::string> files[]{
      {"space.stl", " " + text},
      {"lines.stl", "\r\n\n  " + replaced(text, "\n", "\r\n")},
      {"upper.stl", replaced(replaced(text, "solid", "SOLID"), "facet", "FACET")},
      {"mixed.stl", replaced(replaced(text, "solid", "Solid"), "vertex", "Vertex")},
      {"mark.stl", "\xef\xbb\xbf" + text},
      {"mark_space.stl", "\xef\xbb\xbf  " + text},
      {"one_line.stl", "solid\n" + replaced(text.substr(11), "\n", " ")},
      {"no_name.stl", replaced(text, " body", "")},
      {"odd_name.stl", replaced(text, " body", " outer facet of vertex 3")},
      {"normals.stl", replaced(text, "normal 0 0 0", "normal nan -inf 1")},
      {"solid_binary.stl", "solid by a program" + binary.substr(18)},
      {"space_binary.stl", " solid facet" + binary.substr(12)},
      {"mark_binary.stl", "\xef\xbb\xbfsolid" + binary.substr(8)}};
  for (const auto& [name, content] : files) {
    const MeshOfFile read = read_mesh(folder.write(name, content));
    expect_box(read.mesh, name);
    EXPECT_TRUE(read.repairs.empty()) << name << read.repairs.front();
  }
}

TEST(ReadMesh, SaysWhatItLeavesOut) {
  const testing::SceneFolder folder;
  const std::string binary = binary_stl(box(), 12), text = text_stl(box());
  const std::tuple<const char*, std::string, const char*> files[]{
      {"one.stl", binary + "x", "1 byte behind its 12 triangles"},
      {"two.stl", binary + std::string(2, '\0'), "2 bytes behind its 12 triangles"},
      {"many.stl", binary + std::string(500, '\n'), "500 bytes behind its 12 triangles"},
      {"solid_one.stl", "solid" + binary.substr(5) + "\n", "1 byte behind its 12 triangles"},
      {"no_end.stl", text.substr(0, text.find("endsolid")), "without 'endsolid'"},
      {"more.ply", text_ply(box(), 8, 12) + "7\n", "goes on behind its last element"},
      {"more_binary.ply", binary_ply(box(), 8, 12) + "7", "goes on behind its last element"},
      {"long.ply", replaced(text_ply(box(), 8, 12), "1 2 3\n", "1 2 3 0.5\n"),
       "1 of its lines have more values than"},
      {"long_line.ply", replaced(text_ply(box(), 8, 12), "1 2 3\n", "1 2 3 0.5\n"), "the first is line 17"},
      {"edges.ply", text_ply(box(), 8, 13) + "2 0 1\n", "1 of its faces have fewer than three corners"},
      {"edges.obj", obj(box()) + "f 1 2\n", "1 of its faces have fewer than three corners"},
      {"words.obj", obj(box()) + "F 1 2 3\nfacet\n",
       "2 of its lines begin with a word that OBJ does not have"},
      {"words_line.obj", obj(box()) + "F 1 2 3\nfacet\n", "line 21, 'F'"}};
  for (const auto& [name, content, says] : files) {
    const MeshOfFile read = read_mesh(folder.write(name, content));
    expect_box(read.mesh, name);
    ASSERT_EQ(read.repairs.size(), 1U) << name;
    EXPECT_THAT(read.repairs.front(), HasSubstr(says)) << name;
  }
}

TEST(ReadMesh, BinaryPlyBeginsWithAnyByte) {
  const testing::SceneFolder folder;
  for (int first = 0; first < 256; ++first)
    for (const std::string line_end : {"\n", "\r\n", "\r"}) {
      std::string content = binary_ply(box(), 8, 12);
      const std::size_t data = ply_head("binary_little_endian", 8, 12).size();
      content[data] = char(first);  // of x = 0: up to 3.6e-43
      content = replaced(content.substr(0, data), "\n", line_end) + content.substr(data);
      const TriangleMesh mesh = read_mesh(folder.write("a.ply", content)).mesh;
      ASSERT_EQ(mesh.vertices.size(), 8U) << first;
      ASSERT_NEAR(enclosed_volume(mesh), 6, 1e-12) << first;
    }
}

/// A PLY file of the box whose numbers are of any types and in any order of bytes.
template <class Coordinate, class Count, class Index>
std::string any_ply(const std::array<const char*, 3>& types, bool big_endian) {
  std::string content = fmt::format(
      "ply\nformat binary_{}_endian 1.0\ncomment by hand\nobj_info none\nelement face 12\nproperty list {} "
      "{} "
      "vertex_index\nproperty uchar red\nelement vertex 8\nproperty short s\nproperty {} z\nproperty {} y\n"
      "property {} x\nproperty list uchar short more\nend_header\n",
      big_endian ? "big" : "little", types[1], types[2], types[0], types[0], types[0]);
  const auto add = [&](auto number) {
    std::string raw = bytes(number);
    if (big_endian) std::reverse(raw.begin(), raw.end());
    content += raw;
  };
  for (const auto& t : box().triangles) {
    add(Count(3));
    for (const int v : t) add(Index(v));
    add(std::uint8_t(10));
  }
  for (const Vec3& x : box().vertices) {
    add(std::int16_t(-7));
    for (const int a : {2, 1, 0}) add(Coordinate(x[a]));
    add(std::uint8_t(1));
    add(std::int16_t(9));
  }
  return content;
}

TEST(ReadMesh, PlyOfAnyTypes) {
  const testing::SceneFolder folder;
  for (const bool big : {false, true}) {
    const std::string files[]{
        any_ply<double, std::uint8_t, std::int32_t>({"double", "uchar", "int"}, big),
        any_ply<float, std::int32_t, std::uint32_t>({"float32", "int32", "uint32"}, big),
        any_ply<std::int8_t, std::uint16_t, std::uint8_t>({"char", "ushort", "uint8"}, big),
        any_ply<std::int16_t, std::int8_t, std::int16_t>({"int16", "int8", "short"}, big),
        any_ply<double, std::uint32_t, double>({"float64", "uint", "double"}, big)};
    for (const std::string& content : files)
      expect_box(read_mesh(folder.write("a.ply", content)).mesh, content);
  }
}

TEST(ReadMesh, InDoublePrecision) {
  const testing::SceneFolder folder;
  const TriangleMesh sphere = icosphere(0.5, 8);
  for (const Vec3& far :
       {Vec3(400000, 5000000, 100), Vec3(40000, 50000, 0), Vec3(-4e6, 2e6, -5e6), Vec3(0, 1e8, 0)}) {
    TriangleMesh mesh = sphere;
    for (Vec3& x : mesh.vertices) x = ((x + far) * 64).array().round() / 64;  // exact in all of them
    std::string ply = ply_head("ascii", mesh.vertices.size(), mesh.triangles.size());
    std::string binary = replaced(
        ply_head("binary_little_endian", mesh.vertices.size(), mesh.triangles.size()), "float", "double");
    std::string wavefront;
    for (const Vec3& x : mesh.vertices) {
      ply += fmt::format("{:.6f} {:.6f} {:.6f}\n", x.x(), x.y(), x.z());
      wavefront += fmt::format("v {:.6f} {:.6f} {:.6f}\n", x.x(), x.y(), x.z());
      binary += bytes(x.x(), x.y(), x.z());
    }
    for (const auto& t : mesh.triangles) {
      ply += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
      wavefront += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
      binary += bytes(std::uint8_t(3)) + bytes(t[0], t[1], t[2]);
    }
    for (const auto& path :
         {folder.write("a.obj", wavefront), folder.write("a.ply", ply), folder.write("b.ply", binary)}) {
      const TriangleMesh read = read_mesh(path).mesh;
      ASSERT_EQ(read.vertices.size(), merge_identical(mesh).vertices.size());
      for (std::size_t v = 0; v < read.vertices.size(); ++v)
        EXPECT_EQ(read.vertices[v], merge_identical(mesh).vertices[v]);
    }
  }
}

TEST(ReadMesh, FaultsOfTextNameTheLine) {
  const testing::SceneFolder folder;
  const std::string box_obj = obj(box()), box_stl = text_stl(box()), box_ply = text_ply(box(), 8, 12);
  const std::tuple<const char*, std::string, const char*> files[]{
      {"a.obj", replaced(box_obj, "v 1 0 0", "v 1 0,5 0"), "line 2: '0,5' is no number"},
      {"b.obj", replaced(box_obj, "v 1 0 0", "v 1 0"), "line 2: gives 2 of the three coordinates"},
      {"c.obj", box_obj + "f 1 2 0\n", "line 21: has a face with vertex 0"},
      {"d.obj", box_obj + "f 1 2 9\n", "line 21: has a face with vertex 9"},
      {"e.obj", box_obj + "f 1 two 3\n", "line 21: gives 'two' as a vertex"},
      {"f.obj", "\xff\xfe" + box_obj, "UTF-16"},
      {"a.stl", replaced(box_stl, "vertex 1 2 3\n", "vertex 1 2\n"), "'endloop' is no number"},
      {"b.stl", box_stl.substr(0, 60), "ends within a facet"},
      {"c.stl", replaced(box_stl, "vertex 1 2 3\n", ""), "a facet of 2 vertices"},
      {"a.ply", replaced(box_ply, "ascii", "asci"), "line 2: gives 'asci' as the format"},
      {"b.ply", replaced(box_ply, "property float z\n", ""), "without x, y and z"},
      {"c.ply", replaced(box_ply, "vertex_indices", "corners"), "without a list vertex_indices"},
      {"d.ply", replaced(box_ply, "1 2 3\n", "1 2 three\n"), "line 17: 'three' is no number"}};
  for (const auto& [name, content, says] : files) try {
      read_mesh(folder.write(name, content));
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      expect_sentence(error.what(), {name, "", says});
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
