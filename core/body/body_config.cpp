#include "core/body/body_config.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/base/error.hpp"

namespace mss {

const char* BodyConfig::noun() const {
  const int dimensions = voxels.dimensions();
  return dimensions == 3 ? "a body" : dimensions == 2 ? "a sheet" : "a rope";
}

/// A sheet's springs store ½ k_e (exx² + eyy²) + ½ k_f ((exx + eyy)² + gxy²) of its area, so thickness C11 =
/// k_e + k_f and thickness C12 = thickness C44 = k_f; it is isotropic, C11 - C12 = 2 C44, where k_e = 2 k_f,
/// and plane stress has nu = C12 / C11 and C11 = E / (1 - nu²).
SpringConstants BodyConfig::calibrated(const ElasticConstants& material, double face_share) const {
  if (is_solid()) return calibrate(material, cell_size, face_share);
  if (voxels.dimensions() == 1) return {.edge = material.young * across() * across() / cell_size};
  return {.edge = 3.0 / 4 * material.young * across(), .face = 3.0 / 8 * material.young * across()};
}

double BodyConfig::shear_modulus_of(const SpringConstants& of) const {
  if (is_solid()) return cubic_stiffness(of, cell_size).c44;
  if (voxels.dimensions() == 1) return of.edge * cell_size / (3 * across() * across());
  return of.face / across();
}

double BodyConfig::young_of(const SpringConstants& of, int axis) const {
  if (is_solid()) return cubic_stiffness(of, cell_size).young(Vec3::Unit(axis));
  if (voxels.dimensions() == 1) return of.edge * cell_size / (across() * across());
  return of.edge * (of.edge + 2 * of.face) / ((of.edge + of.face) * across());  // C11 - C12^2 / C11
}

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
  if (body.content_of.size() != voxels.boxed())
    throw InputError(
        fmt::format("contents of {} cells for a box of {}", body.content_of.size(), voxels.boxed()));
  voxels.for_each_place([&](int i, int j, int k) {
    if (voxels.at(i, j, k) && body.content_at(i, j, k) > body.contents.size())
      throw InputError(fmt::format("cell ({}, {}, {}) has content {} of {}", i, j, k,
                                   body.content_at(i, j, k) - 1, body.contents.size()));
  });
}

void resample(BodyConfig& body, int before, int after) {
  const VoxelGrid from = body.voxels;
  const std::vector<std::uint32_t> content_of = std::move(body.content_of);
  body.voxels = VoxelGrid(from.nx() / before * after, from.ny() / before * after, from.nz() / before * after);
  body.content_of.clear();
  body.voxels.for_each_place([&](int i, int j, int k) {
    const int x = i / after * before, y = j / after * before, z = k / after * before;
    body.voxels.set(i, j, k, from.at(x, y, z));
    if (!content_of.empty()) body.content_of.push_back(content_of[from.index(x, y, z)]);
  });
}

}  // namespace mss
