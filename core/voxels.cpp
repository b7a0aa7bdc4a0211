#include "core/voxels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "core/error.hpp"

namespace mss {

VoxelGrid::VoxelGrid(int nx, int ny, int nz, bool filled) : size_{nx, ny, nz} {
  if (nx < 1 || ny < 1 || nz < 1)
    throw InputError(
        fmt::format("a body needs at least one cell along each axis, got {} x {} x {}", nx, ny, nz));
  cells_.assign(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz),
                filled ? 1 : 0);
}

std::size_t VoxelGrid::count() const {
  return static_cast<std::size_t>(std::count(cells_.begin(), cells_.end(), std::uint8_t{1}));
}

namespace {

using Layer = std::vector<std::string>;

/// The layers as text, with every row and layer known to have the size of the first.
std::vector<Layer> read_layers(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in || std::filesystem::is_directory(file))
    throw InputError(
        fmt::format("{}: cannot read this voxel file; give the path of a text file", file.string()));
  std::vector<Layer> layers;
  bool in_layer = false;
  std::string row;
  for (int line = 1; std::getline(in, row); ++line) {
    if (!row.empty() && row.back() == '\r') row.pop_back();
    if (row.find_first_not_of(" \t") == std::string::npos) {
      in_layer = false;
      continue;
    }
    const auto bad = row.find_first_not_of("#.");
    if (bad != std::string::npos)
      throw InputError(fmt::format("{}:{}: found '{}' in a voxel row; use '#' for a cell and '.' for none",
                                   file.string(), line, row[bad]));
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

VoxelGrid VoxelGrid::read(const std::filesystem::path& file) {
  const std::vector<Layer> layers = read_layers(file);
  const auto extent = [](std::size_t n) { return static_cast<int>(n); };
  VoxelGrid grid(extent(layers[0][0].size()), extent(layers[0].size()), extent(layers.size()));
  for (int k = 0; k < grid.nz(); ++k)
    for (int j = 0; j < grid.ny(); ++j)
      for (int i = 0; i < grid.nx(); ++i)
        grid.set(
            i, j, k,
            layers[static_cast<std::size_t>(k)][static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] ==
                '#');
  if (grid.count() == 0)
    throw InputError(
        fmt::format("{}: the voxel file holds no cell; mark at least one with '#'", file.string()));
  return grid;
}

VoxelGrid VoxelGrid::split(int parts) const {
  if (parts == 1) return *this;
  VoxelGrid fine(nx() * parts, ny() * parts, nz() * parts);
  for (int k = 0; k < fine.nz(); ++k)
    for (int j = 0; j < fine.ny(); ++j)
      for (int i = 0; i < fine.nx(); ++i) fine.set(i, j, k, at(i / parts, j / parts, k / parts));
  return fine;
}

VoxelGrid VoxelGrid::merge(int parts) const {
  if (parts == 1) return *this;
  VoxelGrid coarse(nx() / parts, ny() / parts, nz() / parts);
  for (int k = 0; k < coarse.nz(); ++k)
    for (int j = 0; j < coarse.ny(); ++j)
      for (int i = 0; i < coarse.nx(); ++i) coarse.set(i, j, k, at(i * parts, j * parts, k * parts));
  return coarse;
}

}  // namespace mss
