#pragma once

#include <cstddef>
#include <vector>

namespace mss {

/// Twelve numbers per site: nine of a 3 x 3 matrix by rows, then a vector.
inline constexpr int affine_size = 12;

/// Sums of one field over 2 width + 1 sites that are `step` apart.
template <class Real>
struct BoxSum {
  std::ptrdiff_t first, last;  ///< sites to compute; [first, last), in whole vectors
  std::ptrdiff_t step;
  int width;
  const Real* in;
  Real* out;
};

/// What a range of sites needs for the sums of its region, and of the regions it is in.
template <class Real>
struct ShapeSites {
  std::ptrdiff_t first, last;  ///< [first, last), in whole vectors
  const Real* rest[3];         ///< x0 [m]
  const Real* share;        ///< mass over the number of regions, m / |R| [kg]; 0 where there is no particle
  const Real* region_mass;  ///< sum of shares in the region [kg]; 1 where there is no particle
  const Real* rest_centre[3];   ///< of the region [m]
  const Real* inverse_regions;  ///< 1 / |R|; 0 where there is no particle
  const Real* x[3];             ///< [m]
  int turns;                    ///< of every rotation towards the nearest one
  Real* affine[affine_size];    ///< in and out
  Real* rotation[4];            ///< quaternions of the regions, real part last; in and out: a first guess
  const Real* freedom[3];       ///< how much of the way to its goal a coordinate goes; 0 where it is held
  Real* moved[3];               ///< in and out: displacements of the step [m]
};

/// One copy of the loops of shape matching, compiled for one instruction set and precision.
template <class Real>
struct ShapeKernel {
  const char* name;
  int lanes;
  void (*sum)(const BoxSum<Real>&);
  /// affine = (m~ x x0^T, m~ x).
  void (*moments)(const ShapeSites<Real>&);
  /// From sums of moments: affine = (R, c - R c0), R the rotation nearest to the deformation.
  void (*match)(const ShapeSites<Real>&);
  /// From sums of these: moved += freedom (goal - x) with the goal sum (R x0 + t) / |R|.
  void (*approach)(const ShapeSites<Real>&);
};

template <class Real>
const std::vector<ShapeKernel<Real>>& shape_kernels();

}  // namespace mss
