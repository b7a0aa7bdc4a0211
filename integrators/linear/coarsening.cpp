#include "integrators/linear/coarsening.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <vector>

namespace mss {

void add_eighth(const CellContent& fine, CellContent& coarse) {
  for (const PartFill& of_part : fine) {
    const CellFill& fill = of_part.fill;
    auto same =
        std::find_if(coarse.begin(), coarse.end(), [&](const PartFill& p) { return p.part == of_part.part; });
    if (same == coarse.end()) same = coarse.insert(same, {of_part.part, CellFill::even(0)});
    const float mass = std::accumulate(fill.corner.begin(), fill.corner.end(), 0.0F) / 8;
    for (std::size_t c = 0; c < 8; ++c) {
      same->fill.octant[c] += fill.share() / 8;
      same->fill.corner[c] += mass / 8;
    }
  }
}

void set_contents(BodyConfig& body, const std::vector<CellContent>& cells) {
  std::map<std::vector<std::array<float, 3>>, std::uint32_t> known;
  body.contents.clear();
  body.content_of.clear();
  for (const CellContent& cell : cells) {
    if (cell.empty()) {
      body.content_of.push_back(0);  // no cell
      continue;
    }
    std::vector<std::array<float, 3>> key;
    for (const auto& [part, fill] : cell) key.push_back({float(part), fill.octant[0], fill.corner[0]});
    const auto [entry, is_new] = known.try_emplace(key, std::uint32_t(body.contents.size()));
    if (is_new) body.contents.push_back(cell);
    body.content_of.push_back(entry->second);
  }
}

BodyConfig coarsened(const BodyConfig& fine) {
  const VoxelGrid& cells = fine.voxels;
  const auto half = [](int n) { return (n + 1) / 2; };
  BodyConfig coarse = fine;
  coarse.voxels = VoxelGrid(half(cells.nx()), half(cells.ny()), half(cells.nz()));
  const auto [nx, ny, nz] = coarse.voxels.size();
  const CellContent full{PartFill{}};
  std::vector<CellContent> contents(std::size_t(nx) * std::size_t(ny) * std::size_t(nz));
  for (int k = 0; k < cells.nz(); ++k)
    for (int j = 0; j < cells.ny(); ++j)
      for (int i = 0; i < cells.nx(); ++i) {
        if (!cells.at(i, j, k)) continue;
        coarse.voxels.set(i / 2, j / 2, k / 2, true);
        add_eighth(fine.content_of.empty() ? full : fine.contents[fine.content_of[cells.index(i, j, k)]],
                   contents[coarse.voxels.index(i / 2, j / 2, k / 2)]);
      }
  set_contents(coarse, contents);
  coarse.cell_size = 2 * fine.cell_size;
  coarse.sharing = Sharing::weighted;
  const auto coarsen = [](SpringConstants& springs, Damping& damping) {
    for (double* k : {&springs.edge, &springs.face, &springs.body}) *k *= 2;
    // c of a ratio goes with sqrt(k m) ~ h^2, that of a viscosity with h.
    if (damping.law == Damping::Law::ratio) damping.zeta /= 2;
  };
  coarsen(coarse.springs, coarse.damping);
  for (Part& part : coarse.parts) coarsen(part.springs, part.damping);
  return coarse;
}

namespace {

/// Where a coarse row or plane adds to fine ones: 2 i alone, and 2 i +- 1 by half.
struct Share {
  int fine;
  float weight;
};

class Shares {
 public:
  Shares(int coarse, int fine_cells) {
    for (int d = -1; d <= 1; ++d)
      if (const int fine = 2 * coarse + d; fine >= 0 && fine <= fine_cells)
        shares_[count_++] = {fine, d == 0 ? 1.0F : 0.5F};
  }
  const Share* begin() const { return shares_.data(); }
  const Share* end() const { return shares_.data() + count_; }

 private:
  std::array<Share, 3> shares_{};
  std::size_t count_ = 0;
};

}  // namespace

void LatticeTransfer::interpolate_add(const Field<float>& coarse, Field<float>& fine,
                                      const Parallel& parallel) {
  const int nx = fine_.cells[0], ny = fine_.cells[1], nz = fine_.cells[2];
  const std::ptrdiff_t coarse_row = coarse_.row;
  parallel(nz + 1, [&](std::ptrdiff_t k) {
    float* mean = scratch(k);
    mean[coarse_row] = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (std::ptrdiff_t j = 0; j <= ny; ++j) {
        const float* rows[4];
        for (int c = 0; c < 4; ++c)
          rows[c] = coarse.axis(axis) + coarse_.plane * ((k + c / 2) / 2) + coarse_row * ((j + c % 2) / 2);
#pragma omp simd
        for (std::ptrdiff_t i = 0; i < coarse_row; ++i)
          mean[i] = 0.25F * ((rows[0][i] + rows[1][i]) + (rows[2][i] + rows[3][i]));
        float* to = fine.axis(axis) + fine_.plane * k + fine_.row * j;
        for (std::ptrdiff_t i = 0; 2 * i <= nx; ++i) to[2 * i] += mean[i];
        for (std::ptrdiff_t i = 0; 2 * i + 1 <= nx; ++i) to[2 * i + 1] += 0.5F * (mean[i] + mean[i + 1]);
      }
  });
}

void LatticeTransfer::restrict_to(const Field<float>& fine, Field<float>& coarse, const Parallel& parallel) {
  const int ny = fine_.cells[1], nz = fine_.cells[2];
  const std::ptrdiff_t fine_row = fine_.row;
  parallel(coarse_.planes(), [&](std::ptrdiff_t k) {
    float *padded = scratch(k), *sum = padded + 1;  // with a zero before and two behind
    const Shares planes(int(k), nz);
    for (int axis = 0; axis < 3; ++axis)
      for (int j = 0; j <= coarse_.cells[1]; ++j) {
        std::fill_n(padded, fine_row + 3, 0.0F);
        for (const Share& plane : planes)
          for (const Share& row : Shares(j, ny)) {
            const float* from = fine.axis(axis) + fine_.plane * plane.fine + fine_row * row.fine;
            const float weight = plane.weight * row.weight;
#pragma omp simd
            for (std::ptrdiff_t i = 0; i < fine_row; ++i) sum[i] += weight * from[i];
          }
        float* to = coarse.axis(axis) + coarse_.plane * k + coarse_.row * j;
        for (std::ptrdiff_t i = 0; i < coarse_.row; ++i)
          to[i] = sum[2 * i] + 0.5F * (sum[2 * i - 1] + sum[2 * i + 1]);
      }
  });
}

namespace {

/// Where the point at an offset [cells] from the middle of a cell would be, if the cell deformed affinely as
/// its mean edges do.
Vec3 extrapolate(const std::array<Vec3, 8>& corners, const Vec3& offset) {
  Vec3 point = Vec3::Zero();
  for (int c = 0; c < 8; ++c) {
    double weight = 0.125;
    for (int axis = 0; axis < 3; ++axis) weight += 0.25 * corner_sign(c, axis) * offset[axis];
    point += weight * corners[std::size_t(c)];
  }
  return point;
}

/// The mean of what the fine cells within two of a place say.
Vec3 extrapolate(const Body& fine, const Field<float>& x, const std::array<int, 3>& at) {
  const VoxelGrid& cells = fine.config().voxels;
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (int k = at[2] - 2; k < at[2] + 2; ++k)
    for (int j = at[1] - 2; j < at[1] + 2; ++j)
      for (int i = at[0] - 2; i < at[0] + 2; ++i) {
        if (!cells.at(i, j, k)) continue;
        sum += extrapolate(corners_of(fine, x, fine.lattice().site(i, j, k)),
                           Vec3(at[0] - i - 0.5, at[1] - j - 0.5, at[2] - k - 0.5));
        ++count;
      }
  return sum / count;
}

}  // namespace

void coarsen_positions(const Body& fine, const Field<float>& fine_x, const Body& coarse,
                       Field<float>& coarse_x) {
  const Lattice &from = fine.lattice(), &to = coarse.lattice();
  for (const std::ptrdiff_t site : coarse.sites()) {
    std::array<int, 3> at = to.coordinates(site);
    for (int& coordinate : at) coordinate *= 2;
    const bool inside = at[0] <= from.cells[0] && at[1] <= from.cells[1] && at[2] <= from.cells[2];
    const std::ptrdiff_t same = inside ? from.site(at[0], at[1], at[2]) : -1;
    const bool has_particle = inside && fine.particle(same) >= 0;
    coarse_x.set(site, has_particle ? fine_x.at(same) : extrapolate(fine, fine_x, at));
  }
}

}  // namespace mss
