#include "core/body/body_config.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/base/error.hpp"

namespace mss {

bool BodyConfig::is_full() const {
  const CellContent full{PartFill{}};
  return std::all_of(contents.begin(), contents.end(),
                     [&](const CellContent& content) { return content == full; });
}

std::uint32_t BodyConfig::content_at(int i, int j, int k) const {
  if (!voxels.at(i, j, k)) return 0;
  return content_of.empty() ? 1 : 1 + content_of[voxels.index(i, j, k)];
}

const CellContent& BodyConfig::content(std::uint32_t number) const {
  static const CellContent full{PartFill{}};
  return contents.empty() ? full : contents[number - 1];
}

namespace {

void check(const CellContent& content, std::size_t number, std::size_t parts) {
  constexpr float rounding = 1e-5F;
  CellFill all{};
  for (const auto& [part, fill] : content) {
    if (part < 0 || std::size_t(part) >= parts)
      throw InputError(fmt::format("content {} is of part {}, and there are {}", number, part, parts));
    for (std::size_t c = 0; c < 8; ++c) {
      if (!(fill.octant[c] >= 0 && fill.corner[c] >= 0 && std::isfinite(fill.corner[c])))
        throw InputError(fmt::format("content {} fills {} of an octant and gives its corner {} of a mass",
                                     number, fill.octant[c], fill.corner[c]));
      all.octant[c] += fill.octant[c];
    }
  }
  if (const float most = *std::max_element(all.octant.begin(), all.octant.end());
      !(most > 0 && most <= 1 + rounding))
    throw InputError(
        fmt::format("content {} fills {} of an octant; allowed is more than 0, at most 1", number, most));
}

}  // namespace

void check_contents(const BodyConfig& body) {
  if (body.content_of.empty() && body.contents.empty()) return;
  if (body.sharing != Sharing::weighted)
    throw InputError(
        "fill factors and parts need springs that cells share by weight (sharing = \"weighted\")");
  for (std::size_t content = 0; content < body.contents.size(); ++content)
    check(body.contents[content], content, 1 + body.parts.size());
  const VoxelGrid& voxels = body.voxels;
  const auto boxed = std::size_t(voxels.nx()) * std::size_t(voxels.ny()) * std::size_t(voxels.nz());
  if (body.content_of.size() != boxed)
    throw InputError(fmt::format("contents of {} cells for a box of {}", body.content_of.size(), boxed));
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i)
        if (voxels.at(i, j, k) && body.content_at(i, j, k) > body.contents.size())
          throw InputError(fmt::format("cell ({}, {}, {}) has content {} of {}", i, j, k,
                                       body.content_at(i, j, k) - 1, body.contents.size()));
}

void resample(BodyConfig& body, int before, int after) {
  const VoxelGrid from = body.voxels;
  const std::vector<std::uint32_t> content_of = std::move(body.content_of);
  body.voxels = VoxelGrid(from.nx() / before * after, from.ny() / before * after, from.nz() / before * after);
  body.content_of.clear();
  for (int k = 0; k < body.voxels.nz(); ++k)
    for (int j = 0; j < body.voxels.ny(); ++j)
      for (int i = 0; i < body.voxels.nx(); ++i) {
        const int x = i / after * before, y = j / after * before, z = k / after * before;
        body.voxels.set(i, j, k, from.at(x, y, z));
        if (!content_of.empty()) body.content_of.push_back(content_of[from.index(x, y, z)]);
      }
}

}  // namespace mss
