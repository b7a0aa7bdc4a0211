#pragma once

#include <cstddef>
#include <functional>

#include "core/body/body.hpp"

namespace mss {

/// The same materials in cells twice as large, for multigrid: each is filled evenly, with as much of every
/// part as the eight that it replaces have on average, so that odd sizes and ragged shapes keep their
/// stiffness, viscosity and mass.
BodyConfig coarsened(const BodyConfig& fine);

/// Adds to what a cell holds an eighth of what another one does, spread evenly.
void add_eighth(const CellContent& fine, CellContent& coarse);
/// Gives a body a table of the distinct contents of its cells, by VoxelGrid::index(), all filled evenly.
void set_contents(BodyConfig& body, const std::vector<CellContent>& cells);

/// Runs task(0) ... task(count - 1), as System::parallel does.
using Parallel = std::function<void(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task)>;

/// Trilinear interpolation from the lattice of a coarsened body to that of the fine one, and its transpose.
class LatticeTransfer {
 public:
  LatticeTransfer(const Lattice& fine, const Lattice& coarse)
      : fine_(fine), coarse_(coarse), rows_(std::size_t(fine.planes()) * std::size_t(fine.row + 3)) {}

  /// fine += P coarse. Sites without a particle may change too.
  void interpolate_add(const Field<float>& coarse, Field<float>& fine, const Parallel& parallel);
  /// coarse = P^T fine; the fine field must be 0 at sites without a particle.
  void restrict_to(const Field<float>& fine, Field<float>& coarse, const Parallel& parallel);

 private:
  /// Of the task of a plane, which must not allocate: it must not throw.
  float* scratch(std::ptrdiff_t plane) { return rows_.data() + plane * (fine_.row + 3); }

  Lattice fine_, coarse_;
  std::vector<float> rows_;
};

/// Positions of the coarse particles: those of the fine particles at the same places, and where there are
/// none, what the fine cells around say if they deform no further. Sites without a particle stay as they are.
void coarsen_positions(const Body& fine, const Field<float>& fine_x, const Body& coarse,
                       Field<float>& coarse_x);

}  // namespace mss
