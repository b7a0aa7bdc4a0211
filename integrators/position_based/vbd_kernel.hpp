#pragma once

#include <cstddef>
#include <cstdint>

#include "core/kernels/dispatch.hpp"
#include "core/kernels/sweep.hpp"

namespace mss {

/// Sites around one, by (dx + 1) + 3 (dy + 1) + 9 (dz + 1): itself is in the middle.
inline constexpr int sites_around = 27;

/// of[own][other]: the place of a cell's corner `other` among the sites around its corner `own`. An array,
/// not a function, because loops are compiled once per instruction set, see simd.hpp.
struct CornerPlaces {
  int of[8][8] = {};
  constexpr CornerPlaces() {
    for (int own = 0; own < 8; ++own)
      for (int other = 0; other < 8; ++other) {
        of[own][other] = sites_around / 2;
        for (int axis = 0, step = 1; axis < 3; ++axis, step *= 3)
          of[own][other] += step * (corner_bit(other, axis) - corner_bit(own, axis));
      }
  }
};
inline constexpr CornerPlaces corner_places;

/// Numbers per particle that a descent reads: k and c / (dt rsqrt_scale^2) of every neighbour's spring,
/// k_vol / V0 / 64^2 of the eight cells, and m / dt^2.
inline constexpr int descent_coefficients = 2 * sites_around + 8 + 1;

/// Whether particles in the plane below, and in that above, matter to some of W particles.
inline constexpr int plane_below = 1, plane_above = 2;

/// What keeps particles in front of planes during passes.
template <class Real>
class DescentContact {
 public:
  virtual ~DescentContact() = default;
  /// Whether one of that many particles from an index on may meet a plane in this step.
  virtual bool touches(std::ptrdiff_t index, int count) const = 0;
  /// Moves one of them, if it may, from its displacement u with its f and H (xx, yy, zz, yz, zx, xy) below,
  /// in place of u + H^-1 f.
  virtual void move(std::ptrdiff_t index, const Real (&hessian)[6], const Real (&force)[3],
                    const Real (&u)[3]) const = 0;
};

/// What the pass over one colour's particles reads and writes, in the layout of a ColouredLattice.
///
/// Particle i moves to the minimum of the quadratic model of a step's objective in its own coordinates, while
/// all others stay: u_i += H^-1 f with u = x - x_n, and, over the springs s of the particle with differences
/// d to the other ends, d = x_j - x_i, u_s = d / |d|, and over its cells,
///   f = m / dt^2 (y_i - u_i) + sum (k (1 - L0 / |d|) + c / dt (u_j - u_i).d / |d|^2) d
///       - sum k_vol / V0 (V - V0) grad V,
///   H = m / dt^2 I + sum k (u_s u_s^T + max(0, 1 - L0 / |d|) (I - u_s u_s^T)) + c / dt u_s u_s^T
///       + sum k_vol / V0 grad V grad V^T,
/// y the displacement without springs. Chen, Liu, Yang and Yuksel, Vertex block descent, ACM TOG 43 (2024)
/// 116. V is linear in each coordinate of one particle alone, so H has no more terms of it.
template <class Real>
struct Descent {
  std::ptrdiff_t around[sites_around];  ///< from a particle's index within its part to its neighbours'
  const std::uint32_t* entry;           ///< per W of this part: which dictionary entry; 0: nothing to do
  const Real* dictionary;               ///< entries of descent_coefficients x W numbers
  const std::uint8_t* planes;           ///< per entry: plane_below + plane_above, what is not zero of these
  Real rest_length[sites_around];       ///< over rsqrt_scale [m]
  Real rest_volume;                     ///< 64 V0 [m^3]
  ConstStreams<Real> before;            ///< x_n
  ConstStreams<Real> target;            ///< y
  ConstStreams<Real> inverse_mass;      ///< along each axis: 0 where it is held
  Streams<Real> moved;                  ///< u
  const DescentContact<Real>* contact = nullptr;  ///< nullptr: no planes
};

/// One copy of the descent, compiled for one instruction set and precision.
template <class Real>
struct VbdKernel {
  /// Over indices [first, last) within a part, multiples of W.
  using Pass = void (*)(const Descent<Real>&, std::ptrdiff_t first, std::ptrdiff_t last);

  const char* name;
  int lanes;
  Real rsqrt_scale;
  Pass undamped, damped;
};

MSS_KERNEL_COPIES(VbdKernel<float>);
MSS_KERNEL_COPIES(VbdKernel<double>);

}  // namespace mss
