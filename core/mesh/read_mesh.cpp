#include "core/mesh/read_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <new>

#include "core/base/error.hpp"
#include "core/mesh/mesh_repair.hpp"
#include "core/mesh/polygon_mesh.hpp"

namespace mss {

namespace {

constexpr std::uintmax_t most_bytes = std::uintmax_t(1) << 30;

using Reader = PolygonMesh (*)(std::string_view content);

/// By the ending of a file's name.
Reader reader_of(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  if (ending == ".obj") return read_obj;
  if (ending == ".stl") return read_stl;
  if (ending == ".ply") return read_ply;
  throw InputError("is no mesh file by its name; give one that ends in .obj, .stl or .ply");
}

/// Where a path leads, which its relative form does not say.
std::string unreadable(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::path place = std::filesystem::absolute(file, error).lexically_normal();
  return error || place == file
             ? "cannot be read; give the path of a mesh file"
             : "cannot be read, looked for as " + place.string() + "; give the path of a mesh file";
}

std::string read_content(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) || error) throw InputError(unreadable(file));
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw InputError(unreadable(file));
  if (size == 0) throw InputError("is empty; give a mesh file");
  if (size > most_bytes) throw InputError("is larger than 1 GiB; give a mesh of fewer triangles");
  std::string content(size, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in.read(content.data(), std::streamsize(size))) throw InputError(unreadable(file));
  return content;
}

/// Repairs a mesh, and says how.
void repair(MeshOfFile& file) {
  const std::size_t triangles = file.mesh.triangles.size();
  if (const std::size_t joined = weld_seams(file.mesh); joined > 0)
    file.repairs.push_back(
        fmt::format("{} of its vertices at open edges were joined with others, nearer than {:g} of its "
                    "longest extent",
                    joined, weld_tolerance));
  if (const std::size_t turned = turn_alike(file.mesh); turned > 0)
    file.repairs.push_back(
        fmt::format("{} of its {} triangles faced the other way than their neighbours, and were turned",
                    turned, triangles));
}

}  // namespace

MeshOfFile read_mesh(const std::filesystem::path& file) {
  try {
    const std::string content = read_content(file);
    if (content.starts_with("\xff\xfe") || content.starts_with("\xfe\xff"))
      throw InputError("is text in UTF-16; save it as UTF-8");
    PolygonMesh polygons = reader_of(file)(content);
    MeshOfFile result{.mesh = merge_identical(triangles_of(polygons)),
                      .repairs = std::move(polygons.remarks)};
    if (const std::size_t count = short_faces(polygons); count > 0)
      result.repairs.push_back(
          fmt::format("{} of its faces have fewer than three corners, and are left out", count));
    repair(result);
    if (result.mesh.triangles.empty()) throw InputError("has no triangles; give the surface of a solid");
    return result;
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  } catch (const std::bad_alloc&) {
    throw InputError(file.string() + ": needs more memory than there is; give a mesh of fewer triangles");
  }
}

}  // namespace mss
