#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace mss {

/// Cells around a mesh, with sample points in them: each cell has `samples`^3, at the centres of as many
/// equal parts of it. Sample (a, b, c) of a cell is bit a + samples (b + samples c) of a 64-bit mask.
struct SampleGrid {
  Vec3 origin = Vec3::Zero();  ///< lower corner of the first cell [m]
  double cell_size = 1;        ///< [m]
  std::array<int, 3> cells{1, 1, 1};
  int samples = 4;  ///< per edge of a cell, up to 4

  /// From a bit of a mask to that of the next sample along x, y and z.
  std::array<int, 3> bit_steps() const { return {1, samples, samples * samples}; }
  double spacing() const { return cell_size / samples; }
  std::size_t per_cell() const { return std::size_t(samples) * std::size_t(samples) * std::size_t(samples); }
  std::size_t cell_count() const {
    return std::size_t(cells[0]) * std::size_t(cells[1]) * std::size_t(cells[2]);
  }
  /// As VoxelGrid::index().
  std::size_t index(const std::array<int, 3>& cell) const {
    return std::size_t(cell[0]) +
           std::size_t(cells[0]) * (std::size_t(cell[1]) + std::size_t(cells[1]) * std::size_t(cell[2]));
  }
  std::array<int, 3> cell(std::size_t index) const;
  Vec3 centre(std::size_t index) const;           ///< of a cell [m]
  Vec3 sample(std::size_t index, int bit) const;  ///< [m]
};

/// A sample within half a step of where a line through it crosses the surface.
struct BorderSample {
  float gap;  ///< from the surface, along the line, in steps
  std::uint32_t cell;
  std::uint8_t bit;
  bool inside;
};

/// Which samples of a grid lie inside a mesh, and what there was to say about it. Shares are of the samples
/// inside.
struct InsideSamples {
  std::vector<std::uint64_t> masks;  ///< by cell
  std::int64_t inside = 0;
  double undecided = 0;    ///< winding number more than .1 from a whole number: near openings
  double overlapping = 0;  ///< winding number 2 or more: counted once
  double reversed = 0;     ///< winding number below zero: not inside, but a shell that is inside out is there
  double contested = 0;    ///< lines along three axes did not agree: on the surface, within rounding
  std::vector<BorderSample> border{};
};

/// Largest share of undecided samples for which inside has a meaning.
inline constexpr double most_undecided = 0.1;

/// A sample is inside where the winding number exceeds 1/2. `closed_mesh` is closed(): its triangles from
/// `first_cap` on are not the surface's own. Of this closed surface the signed crossings of the lines through
/// the samples give the winding number, a whole one; lines along all three axes vote. From it the winding
/// number of the caps is subtracted where it matters, near openings. `orientation` is -1 if the surface is
/// inside out, else 1.
///
/// Each line counts a crossing of an edge or vertex once, whatever the rounding: triangles project onto
/// half-open intervals whose ends depend on nothing but the edge.
///
/// Stops early, with `undecided` above most_undecided and masks of the closed surface, where that is so.
/// Throws InputError for a surface that crosses one layer of cells more than 2^25 times.
InsideSamples find_inside(const TriangleMesh& closed_mesh, std::size_t first_cap, double orientation,
                          const SampleGrid& grid);

/// Mean of the samples inside [m], of which there must be some.
Vec3 centre_of(const std::vector<std::uint64_t>& masks, const SampleGrid& grid);

/// Moves the samples that are nearest to the surface in or out until their number fits a volume [m^3], as if
/// the surface moved by a small part of a step. Samples alone err by .5 percent of the volume of a sphere of
/// 5 cells across, and by a layer of them where a face is parallel to the lattice. Of equally near samples
/// those come first that a hash of their place says, so that they are spread evenly.
void match_volume(InsideSamples& samples, double volume, const SampleGrid& grid);

}  // namespace mss
