#pragma once

#include <cstddef>
#include <cstdint>

#include "core/kernels/dispatch.hpp"
#include "core/kernels/sweep.hpp"

namespace mss {

/// Numbers per cell that a projection reads: of every spring A, B and G, then those of the volume, see
/// Projection.
inline constexpr int projection_coefficients = 3 * springs_per_site + 1;

/// Constraints that a cell projects: its thirteen springs and its volume.
inline constexpr int constraints_per_cell = springs_per_site + 1;

/// What the pass over one colour's cells reads and writes. Streams and arrays have the layout of a
/// ColouredLattice; `corner` leads from a cell's index to its corners.
///
/// u = x - x_n are the displacements of the step, n the direction of a spring from its second end to its
/// first, w inverse masses. A spring's projection is
///   dlam = -(C + at lam + gam n.(u_a - u_b)) / ((1 + gam) (w_a + w_b) + at),  u_a += w_a dlam n,
///   u_b -= w_b dlam n
/// with C = |x_a - x_b| - L0, at = 1 / (k dt^2), gam = c / (k dt). Multiplied by k dt^2, numerator and
/// denominator exist for k = 0 too, and the denominator does not depend on positions. So with
/// g = 1 / ((k dt^2 + c dt) (w_a + w_b) + 1) the coefficients are
///   A = k dt^2 g, B = c dt g, G = g,
/// A and B over the square of rsqrt_scale. Of the volume, C = V - V0, the coefficient is k_vol dt^2 / V0; its
/// gradient, and so its denominator, changes with positions.
template <class Real>
struct Projection {
  std::ptrdiff_t corner[8];
  const std::uint32_t* entry;   ///< per W cells of this colour: which dictionary entry; 0: nothing to do
  const Real* dictionary;       ///< entries of projection_coefficients x W numbers
  const std::uint8_t* is_flat;  ///< per entry: whether it has springs between corners 0 to 3 only
  Real rest_length[springs_per_site];  ///< times rsqrt_scale [m]
  Real rest_volume;                    ///< V0 [m^3]
  ConstStreams<Real> before;           ///< x_n
  ConstStreams<Real> inverse_mass;     ///< along each axis: 0 where it is held
  Streams<Real> moved;                 ///< u
  Real* multipliers;                   ///< constraints_per_cell x W numbers per W cells of this colour
};

/// Arrays that the beginning and the end of a step go through, site by site.
template <class Real>
struct ProjectionStep {
  std::ptrdiff_t first, last;  ///< multiples of W; [first, last)
  Streams<Real> x, v, moved;
  Streams<Real> target;  ///< may be `moved`
  ConstStreams<Real> acceleration;
  Real dt;
};

/// One copy of the projection, compiled for one instruction set and precision.
template <class Real>
struct XpbdKernel {
  /// Over cells [first, last) of a colour, multiples of W.
  using Pass = void (*)(const Projection<Real>&, std::ptrdiff_t first, std::ptrdiff_t last);

  const char* name;
  int lanes;
  Real rsqrt_scale;
  /// u = dt v, then target = dt v + dt^2 a.
  void (*predict)(const ProjectionStep<Real>&);
  /// The end of a step and the beginning of the next, without storing v: the same bits as one after the
  /// other.
  void (*proceed)(const ProjectionStep<Real>&);
  /// x += u, v = u / dt.
  void (*finish)(const ProjectionStep<Real>&);
  /// Without damping; with it; the same with multipliers kept from one pass to the next, and masses that
  /// differ between axes. The first two begin with lam = 0 and do not keep it, and take the masses along x
  /// for all axes.
  Pass undamped, damped, general;
};

MSS_KERNEL_COPIES(XpbdKernel<float>);
MSS_KERNEL_COPIES(XpbdKernel<double>);

}  // namespace mss
