#include "core/body/voxels.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "core/base/error.hpp"

namespace mss {

VoxelGrid::VoxelGrid(int nx, int ny, int nz, bool filled) : size_{nx, ny, nz} {
  if (nx < 0 || ny < 0 || nz < 0 || dimensions() == 0)
    throw InputError(
        fmt::format("a body needs at least one cell along some axis, got {} x {} x {}", nx, ny, nz));
  std::size_t boxed = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    step_[axis] = size_[axis] == 0 ? 0 : boxed;
    boxed *= static_cast<std::size_t>(places(axis));
  }
  cells_.assign(boxed, filled ? 1 : 0);
}

std::size_t VoxelGrid::count() const {
  return static_cast<std::size_t>(std::count(cells_.begin(), cells_.end(), std::uint8_t{1}));
}

namespace {

using Layer = std::vector<std::string>;

constexpr std::uintmax_t most_voxel_bytes = std::uintmax_t(1) << 30;

/// Of the part that a cell's letter names, 0 for '#' and digits; -1: there is none.
int part_of(char cell, const std::vector<std::string>& parts) {
  if (cell < 'A' || cell > 'Z') return 0;
  const auto named = std::find(parts.begin(), parts.end(), std::string(1, cell));
  return named == parts.end() ? -1 : int(named - parts.begin()) + 1;
}

/// A character that can be seen, or its code.
std::string shown_cell(char cell) {
  return cell >= ' ' && cell < 0x7f ? fmt::format("'{}'", cell)
                                    : fmt::format("the byte {}", int(static_cast<unsigned char>(cell)));
}

/// What is wrong with a cell, and what to give instead; empty: nothing.
std::string problem_of(char cell, const std::vector<std::string>& parts) {
  if (part_of(cell, parts) < 0)
    return fmt::format("no part has that name; the names of [[part]] are {}",
                       parts.empty() ? "none" : fmt::format("{}", fmt::join(parts, ", ")));
  const bool known =
      cell == '#' || cell == '.' || (cell >= '1' && cell <= '9') || (cell >= 'A' && cell <= 'Z');
  return known ? ""
               : "use '#' for a full cell, 1 to 9 for tenths of one, the letter of a [[part]], and '.' for "
                 "none";
}

CellContent content_of(char cell, const std::vector<std::string>& parts) {
  const bool is_tenths = cell >= '1' && cell <= '9';
  return {{part_of(cell, parts), CellFill::even(is_tenths ? float(cell - '0') / 10 : 1)}};
}

/// The layers as text, with every row and layer known to have the size of the first.
std::vector<Layer> read_layers(const std::filesystem::path& file, const std::vector<std::string>& parts) {
  std::error_code error;
  std::ifstream in(file);
  if (!in || !std::filesystem::is_regular_file(file, error))
    throw InputError(
        fmt::format("{}: cannot read this voxel file; give the path of a text file", file.string()));
  if (std::filesystem::file_size(file, error) > most_voxel_bytes)
    throw InputError(
        fmt::format("{}: this voxel file is larger than 1 GiB; give fewer cells", file.string()));
  std::vector<Layer> layers;
  bool in_layer = false;
  std::string row;
  for (int line = 1; std::getline(in, row); ++line) {
    if (!row.empty() && row.back() == '\r') row.pop_back();
    if (row.find_first_not_of(" \t") == std::string::npos) {
      in_layer = false;
      continue;
    }
    for (const char cell : row)
      if (const std::string problem = problem_of(cell, parts); !problem.empty())
        throw InputError(fmt::format("{}:{}: found {} in a voxel row; {}", file.string(), line,
                                     shown_cell(cell), problem));
    if (!in_layer) layers.emplace_back();
    in_layer = true;
    if (row.size() != (layers.front().empty() ? row : layers.front().front()).size())
      throw InputError(
          fmt::format("{}:{}: this row has {} cells, the first has {}; make all rows equally long",
                      file.string(), line, row.size(), layers.front().front().size()));
    layers.back().push_back(row);
  }
  if (layers.empty())
    throw InputError(fmt::format("{}: the voxel file is empty; write rows of '#' and '.'", file.string()));
  for (std::size_t k = 0; k < layers.size(); ++k)
    if (layers[k].size() != layers.front().size())
      throw InputError(fmt::format("{}: layer {} has {} rows, layer 1 has {}; make all layers equally large",
                                   file.string(), k + 1, layers[k].size(), layers.front().size()));
  return layers;
}

}  // namespace

VoxelFile read_voxels(const std::filesystem::path& file, const std::vector<std::string>& parts) {
  const std::vector<Layer> layers = read_layers(file, parts);
  const auto extent = [](std::size_t n) { return static_cast<int>(n); };
  VoxelFile read{VoxelGrid(extent(layers[0][0].size()), extent(layers[0].size()), extent(layers.size()))};
  std::string kinds;  // of cells, in the order of their contents
  for (int k = 0; k < read.voxels.nz(); ++k)
    for (int j = 0; j < read.voxels.ny(); ++j)
      for (int i = 0; i < read.voxels.nx(); ++i) {
        const char cell =
            layers[static_cast<std::size_t>(k)][static_cast<std::size_t>(j)][static_cast<std::size_t>(i)];
        read.voxels.set(i, j, k, cell != '.');
        if (cell != '.' && kinds.find(cell) == std::string::npos) kinds += cell;
        read.content_of.push_back(cell == '.' ? 0 : std::uint32_t(kinds.find(cell)));
      }
  if (read.voxels.count() == 0)
    throw InputError(
        fmt::format("{}: the voxel file holds no cell; mark at least one with '#'", file.string()));
  if (kinds == "#")
    read.content_of.clear();
  else
    for (const char kind : kinds) read.contents.push_back(content_of(kind, parts));
  return read;
}

}  // namespace mss
