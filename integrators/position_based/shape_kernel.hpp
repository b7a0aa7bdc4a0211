#pragma once

#include <cstddef>

#include "core/kernels/dispatch.hpp"

namespace mss {

/// Twelve numbers per site: nine of a 3 x 3 matrix by rows, then a vector.
inline constexpr int affine_size = 12;

/// Sums of one field over 2 width + 1 sites that are `step` apart.
struct BoxSum {
  std::ptrdiff_t first, last;  ///< sites to compute; [first, last), in whole vectors
  std::ptrdiff_t step;
  int width;
  const double* in;
  double* out;
};

/// What a range of sites needs for the sums of its region, and of the regions it is in.
struct ShapeSites {
  std::ptrdiff_t first, last;  ///< [first, last), in whole vectors
  const double* rest[3];       ///< x0 [m]
  const double* share;        ///< mass over the number of regions, m / |R| [kg]; 0 where there is no particle
  const double* region_mass;  ///< sum of shares in the region [kg]; 1 where there is no particle
  const double* rest_centre[3];   ///< of the region [m]
  const double* inverse_regions;  ///< 1 / |R|; 0 where there is no particle
  const double* x[3];             ///< [m]
  int turns;                      ///< of every rotation towards the nearest one
  double* affine[affine_size];    ///< in and out
  double* rotation[4];            ///< quaternions of the regions, real part last; in and out: a first guess
  const double* freedom[3];       ///< how much of the way to its goal a coordinate goes; 0 where it is held
  double* moved[3];               ///< in and out: displacements of the step [m]
};

/// One copy of the loops of shape matching, compiled for one instruction set.
struct ShapeKernel {
  const char* name;
  int lanes;
  void (*sum)(const BoxSum&);
  /// affine = (m~ x x0^T, m~ x).
  void (*moments)(const ShapeSites&);
  /// From sums of moments: affine = (R, c - R c0), R the rotation nearest to the deformation.
  void (*match)(const ShapeSites&);
  /// From sums of these: moved += freedom (goal - x) with the goal sum (R x0 + t) / |R|.
  void (*approach)(const ShapeSites&);
};

MSS_KERNEL_COPIES(ShapeKernel);

}  // namespace mss
