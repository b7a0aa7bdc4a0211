// The only file that names assimp.
#include "core/mesh/read_mesh.hpp"

#include <assimp/MemoryIOWrapper.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <fstream>
#include <string>

#include "core/base/error.hpp"
#include "core/mesh/mesh_file_checks.hpp"

namespace mss {

namespace {

constexpr std::uintmax_t most_bytes = std::uintmax_t(1) << 30;
constexpr float largest_coordinate = 1e15F;

unsigned char byte(char c) { return static_cast<unsigned char>(c); }

/// The ending of a file's name in small letters, one of those that are known.
std::string format_of(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return char(std::tolower(byte(c))); });
  if (ending != ".obj" && ending != ".stl" && ending != ".ply")
    throw InputError("is no mesh file by its name; give one that ends in .obj, .stl or .ply");
  return ending.substr(1);
}

std::string read_content(const std::filesystem::path& file) {
  constexpr auto unreadable = "cannot be read; give the path of a mesh file";
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) || error) throw InputError(unreadable);
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw InputError(unreadable);
  if (size == 0) throw InputError("is empty; give a mesh file");
  if (size > most_bytes) throw InputError("is larger than 1 GiB; give a mesh of fewer triangles");
  std::string content(size, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in.read(content.data(), std::streamsize(size))) throw InputError(unreadable);
  return content;
}

/// Writes the zero before the points of numbers such as .5, which assimp does not take for numbers in OBJ.
std::string with_leading_zeros(const std::string& content) {
  std::string result;
  result.reserve(content.size());
  for (std::size_t i = 0; i < content.size(); ++i) {
    const bool bare = i > 0 && i + 1 < content.size() && content[i] == '.' &&
                      std::isspace(byte(content[i - 1])) && std::isdigit(byte(content[i + 1]));
    if (bare) result += '0';
    result += content[i];
  }
  return result;
}

/// What assimp would use unchecked when it divides polygons.
void check(const aiMesh& mesh) {
  for (unsigned v = 0; v < mesh.mNumVertices; ++v)
    for (unsigned a = 0; a < 3; ++a)
      if (!(std::abs(mesh.mVertices[v][a]) <= largest_coordinate))
        throw InputError(
            fmt::format("has a vertex at ({}, {}, {}); give coordinates that are finite and at most 1e15 m",
                        mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z));
  for (unsigned f = 0; f < mesh.mNumFaces; ++f)
    for (unsigned c = 0; c < mesh.mFaces[f].mNumIndices; ++c)
      if (const unsigned index = mesh.mFaces[f].mIndices[c]; index >= mesh.mNumVertices)
        throw InputError(fmt::format("has a face with vertex {}, but {} vertices; export the mesh again",
                                     int(index), mesh.mNumVertices));
}

/// Says of what kinds a mesh's faces are. Assimp's readers say what kinds a format has, and its division of
/// polygons ends the program where there are none; no kind at all means to it that all may be there.
void set_types(aiMesh& mesh) {
  mesh.mPrimitiveTypes = 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const unsigned corners = mesh.mFaces[f].mNumIndices;
    mesh.mPrimitiveTypes |= corners < 2    ? aiPrimitiveType_POINT
                            : corners == 2 ? aiPrimitiveType_LINE
                            : corners == 3 ? aiPrimitiveType_TRIANGLE
                                           : aiPrimitiveType_POLYGON;
  }
}

void add(const aiMesh& mesh, const aiMatrix4x4& transform, TriangleMesh& all) {
  const auto first = int(all.vertices.size());
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D x = transform * mesh.mVertices[v];
    all.vertices.emplace_back(x.x, x.y, x.z);
  }
  for (unsigned f = 0; f < mesh.mNumFaces; ++f)
    if (const aiFace& face = mesh.mFaces[f]; face.mNumIndices == 3)
      all.triangles.push_back(
          {first + int(face.mIndices[0]), first + int(face.mIndices[1]), first + int(face.mIndices[2])});
}

void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent, TriangleMesh& all) {
  const aiMatrix4x4 transform = parent * node.mTransformation;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) add(*scene.mMeshes[node.mMeshes[m]], transform, all);
  for (unsigned c = 0; c < node.mNumChildren; ++c) add_node(scene, *node.mChildren[c], transform, all);
}

/// The first line of what a library says, without its full stop.
std::string one_line(std::string text) {
  text = text.substr(0, std::min(text.find_first_of("\r\n"), std::size_t(200)));
  while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
  return text;
}

TriangleMesh import(const std::string& content, const std::string& format) {
  Assimp::Importer importer;
  // nothing but this file is opened, so no materials beside it
  importer.SetIOHandler(
      new Assimp::MemoryIOSystem(reinterpret_cast<const uint8_t*>(content.data()), content.size(), nullptr));
  const aiScene* scene = importer.ReadFile(AI_MEMORYIO_MAGIC_FILENAME "." + format, 0);
  if (scene == nullptr)
    throw InputError(fmt::format("is no mesh that can be read ({}); export it again",
                                 one_line(importer.GetErrorString())));
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    check(*scene->mMeshes[m]);
    set_types(*scene->mMeshes[m]);
  }
  if (scene->mNumMeshes > 0) scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  TriangleMesh mesh;
  if (scene != nullptr && scene->mRootNode != nullptr)
    add_node(*scene, *scene->mRootNode, aiMatrix4x4(), mesh);
  if (mesh.triangles.empty()) throw InputError("has no triangles; give the surface of a solid");
  return merge_identical(mesh);
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& file) {
  try {
    const std::string content = read_content(file);
    const std::string format = format_of(file);
    if (format == "stl") check_stl(content);
    if (format == "ply") check_ply(content);
    return import(format == "obj" ? with_leading_zeros(content) : content, format);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  } catch (const std::exception& error) {  // of the library, out of memory included
    throw InputError(fmt::format("{}: is no mesh that can be read ({}); export it again", file.string(),
                                 one_line(error.what())));
  }
}

}  // namespace mss
