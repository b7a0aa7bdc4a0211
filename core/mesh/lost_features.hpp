#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace mss {

struct SampleGrid;

/// A piece of a solid in cells that have none of its samples, so that no particle carries it: a fin, a wire.
struct LostFeature {
  Box box{};                       ///< of its surface [m]
  double area = 0;                 ///< of its surface [m^2]
  double volume = 0;               ///< [m^3]
  std::vector<std::size_t> cells;  ///< of the grid, ascending

  /// Of a plate of this volume and surface [m]; a rod's is its radius.
  double thickness() const { return area > 0 ? 2 * volume / area : 0; }
};

/// The pieces of a surface in cells without samples, further than half a cell from all cells that have some;
/// the largest first. Those of shells that are inside out are no part of the solid, and left out.
/// `closed_mesh`, `first_cap` and `orientation` are as for find_inside(), `masks` the samples inside, by
/// cell.
std::vector<LostFeature> find_lost_features(const TriangleMesh& closed_mesh, std::size_t first_cap,
                                            double orientation, const std::vector<std::uint64_t>& masks,
                                            const SampleGrid& grid);

}  // namespace mss
