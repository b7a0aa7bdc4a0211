#pragma once

#include <cstddef>

#include "core/base/lattice.hpp"
#include "core/body/spring_slots.hpp"
#include "core/kernels/dispatch.hpp"

namespace mss {

/// The tangent a M + b C + c K of a lattice of springs at rest, in single precision. Springs pull along
/// constant directions, so a product needs no position, root or division: thirteen numbers a site and one a
/// cell. Pointers are to site 0; a plane, a row and a site before it and behind the last may be read.
///
/// For a spring between sites i and j = i + offset, whose coordinates differ by e in {-1, 0, 1}^3:
///   f_i = w (e.(u_j - u_i)) e,  f_j = -f_i,  w = (c k + b d) / |e|^2,
/// for the volume force of a cell, to first order k_vol h^2/16 (sum over corners of s.u) s, s in {-1, 1}^3.
struct RestStencil {
  const float* spring[spring_slots.size()];    ///< w by slot, at the end that comes first
  std::ptrdiff_t offset[spring_slots.size()];  ///< to the other end
  const float* cell;                           ///< c k_vol h/16 of the cell at a site
  const float* mass;                           ///< a m
  const float* inverse[6];                     ///< of the blocks on the diagonal: xx, yy, zz, yz, zx, xy
  std::ptrdiff_t row, plane;
};

/// A step of Chebyshev's iteration: r -= A d; with `direction`, then d' = keep d + add D^-1 r, z += d'.
struct RestSmoothing {
  const float* d[3];
  const float* pressure;  ///< of d, as RestKernels::pressure leaves it
  float* r[3];
  float* direction[3];  ///< d'; nullptr: the product alone
  float* z[3];
  float keep, add;
};

/// Between a lattice and that of cells twice as large.
struct RestTransfer {
  int fine_cells[3], coarse_cells[3];
  std::ptrdiff_t fine_row, fine_plane, coarse_row, coarse_plane;
};

/// Loops of the V-cycle at rest (rest_level.hpp) over sites [first, last), multiples of 16.
struct RestKernels {
  const char* name;

  /// Of every cell: its number times the sum over corners of s.d.
  void (*pressure)(const RestStencil&, const float* const d[3], float* out, std::ptrdiff_t first,
                   std::ptrdiff_t last);
  void (*smooth)(const RestStencil&, const RestSmoothing&, std::ptrdiff_t first, std::ptrdiff_t last);
  /// d = add D^-1 r, z = d, or if it is `continued` z += d
  void (*start)(const RestStencil&, const float* const r[3], float add, bool continued, float* const d[3],
                float* const z[3], std::ptrdiff_t first, std::ptrdiff_t last);
  /// Of a plane of the coarse lattice: P^T r, with room for a fine plane and three numbers in `scratch`.
  void (*restrict_plane)(const RestTransfer&, const float* fine, float* coarse, int plane, float* scratch);
  /// Of a plane of the fine lattice: d = P z_c, z += d; the same room.
  void (*interpolate_plane)(const RestTransfer&, const float* coarse, float* d, float* z, int plane,
                            float* scratch);
  /// y = A x of rows [first, last), multiples of 16; A has so many rows and columns, stored by columns.
  void (*multiply)(const float* a, std::ptrdiff_t n, const float* x, float* y, std::ptrdiff_t first,
                   std::ptrdiff_t last);

  /// r = scale Q^T g, Q = (q[0..2]; q[3..5]; q[6..8]) by rows.
  void (*turn_back)(const float* const q[9], const double* const g[3], double scale, float* const r[3],
                    std::ptrdiff_t first, std::ptrdiff_t last);
  /// out = scale Q z
  void (*turn)(const float* const q[9], const float* const z[3], double scale, double* const out[3],
               std::ptrdiff_t first, std::ptrdiff_t last);
  /// out = scale (x - middle)
  void (*scale_positions)(const double* const x[3], const double middle[3], double scale, float* const out[3],
                          std::ptrdiff_t first, std::ptrdiff_t last);
  /// Rotations next to the mean of the edges that a particle has along each axis, from positions over the
  /// cell size. `shares`: of the edges ahead and behind, axis by axis; 0 of particles that do not turn, whose
  /// Q is `unit` times the identity.
  void (*rotations)(const RestStencil&, const float* const x[3], const float* const shares[6],
                    const float* unit, float* const q[9], std::ptrdiff_t first, std::ptrdiff_t last);
};

MSS_KERNEL_COPIES(RestKernels);

}  // namespace mss
