#pragma once

#include <cstddef>
#include <cstdint>

#include "core/kernels/dispatch.hpp"
#include "core/kernels/local_step.hpp"

namespace mss {

/// Contents of a block of W neighbouring sites: bits that let the sweep skip whole groups of springs.
enum BlockContent : std::uint32_t {
  block_edges = 1,
  block_faces = 2,
  block_bodies = 4,
  block_volumes = 8,
  block_guards = 16  ///< against folding
};

inline constexpr int springs_per_site = 13;

/// A block's coefficients, W numbers each: the seven weights of a site's springs, see SiteWeights; where
/// dampers have no time in common (SiteKinds::damping_time) the dampings c of all thirteen, divided by the
/// square of rsqrt_scale; where parts have other ratios of k_vol or k_g to the body diagonals' stiffness the
/// weights of a cell's k_vol and k_g. Elsewhere dampers have the weights of their springs, both others that
/// of the body diagonals.
inline constexpr int weights_per_lane = 7;

/// What weights multiply. The spring force over d is k + r (c (r d.u) - k L0) with r = 1/|d|, d and u the
/// differences of x and v. The kernel computes rsqrt_scale / |d|, so k L0 is stored divided by rsqrt_scale
/// and c by its square.
template <class Real>
struct InteriorCoefficients {
  Real stiffness[springs_per_site];    ///< k
  Real rest_pull[springs_per_site];    ///< k L0 / rsqrt_scale
  Real rest_length[springs_per_site];  ///< L0 / rsqrt_scale
  Real damping[springs_per_site];      ///< c, if dampers have the weights of their springs
  Real volume;                         ///< k_vol / (64 V0)
  Real guard;                          ///< guarded_corner_stiffness()
};

/// The three coordinates of a field, as raw pointers.
template <class Real>
struct Streams {
  Real* axis[3];
};
template <class Real>
struct ConstStreams {
  const Real* axis[3];
};

/// Blocks that follow each other in a plane without gaps.
struct BlockRun {
  std::ptrdiff_t first;  ///< their sites, counted from the plane's first: [first, last)
  std::ptrdiff_t last;
};

/// What one plane of the sweep reads and writes. Pointers to fields start at the plane's first site; scratch
/// planes have `plane` numbers per axis.
template <class Real>
struct SweepPlane {
  std::ptrdiff_t row;
  std::ptrdiff_t plane;
  const BlockRun* first_run;  ///< to compute: [first_run, last_run)
  const BlockRun* last_run;
  const std::uint32_t* entry;  ///< per block of these, and two more: which dictionary entry
  const Real* dictionary;      ///< entries of entry_size numbers
  std::ptrdiff_t entry_size;
  bool own_dampings;             ///< whether an entry has the dampings of its springs
  std::ptrdiff_t volume_weight;  ///< where in an entry are the weights of k_vol
  std::ptrdiff_t guard_weight;   ///< and of k_g
  const std::uint32_t* content;  ///< per entry: BlockContent bits
  InteriorCoefficients<Real> interior;
  Real rest_volume;     ///< V0 [m^3]
  Real guarded_length;  ///< stretch of a corner below which the fold guard acts [m]
  ConstStreams<Real> x;
  ConstStreams<Real> v;  ///< velocities, or the directions of a product
  Real stiffness;        ///< weights of a product's K and C
  Real damping;
  Streams<Real> own;    ///< sums from this plane's cells; filled row by row
  Streams<Real> above;  ///< sums from this plane's cells for the next plane
  Real carry[4][3];     ///< in and out: the last lane of the four (x+1) corners
};

/// The update of particles once their force, own + below, is complete.
template <class Real>
struct FinishPlane {
  const BlockRun* first_run;  ///< to finish: [first_run, last_run)
  const BlockRun* last_run;
  ConstStreams<Real> own;
  ConstStreams<Real> below;
  const Real* inverse_mass;
  Real gravity[3];
  Streams<Real> x;
  Streams<Real> v;
  Streams<Real> out;             ///< receives force, acceleration or product
  ConstStreams<Real> direction;  ///< of a product
  Real mass;                     ///< weight of a product's M
  Real kick_before, kick_after, drift_old, drift_new;
};

template <class Real>
using Sweep = void (*)(SweepPlane<Real>&);

/// One for any body, and leaner ones without code for contents that no cell of a body has.
template <class Real>
struct ForceSweeps {
  Sweep<Real> any, edges_and_faces, no_volumes, no_bodies, no_faces;

  /// The leanest for a body whose blocks together have these BlockContent bits.
  Sweep<Real> for_content(std::uint32_t content) const {
    if ((content & (block_bodies | block_volumes)) == 0) return edges_and_faces;
    if ((content & block_faces) == 0) return no_faces;
    if ((content & block_volumes) == 0) return no_volumes;
    return (content & block_bodies) == 0 ? no_bodies : any;
  }
};

/// Sweeps of a plane's blocks.
template <class Real>
struct Sweeps {
  /// Forces of springs and cells: with dampings of their own, with dampers that have the weights of their
  /// springs, and without dampers, which do not read velocities.
  ForceSweeps<Real> own_dampings, weighted_dampers, undamped;
  /// -(b C + c K) p in place of forces, with p in `v`; elastic or projected (see Tangent).
  Sweep<Real> elastic, projected;
  /// The 3 x 3 blocks on the diagonal of b C + c K in place of forces: xx, yy, zz or yz, zx, xy.
  struct DiagonalSweeps {
    Sweep<Real> straight, mixed;
  };
  DiagonalSweeps elastic_diagonal, projected_diagonal;
};

/// One copy of the sweep, compiled for one instruction set and precision.
template <class Real>
struct SweepKernel {
  const char* name;  ///< "x86-64-v3" and the like
  int lanes;         ///< W
  Real rsqrt_scale;
  Sweeps<Real> plain;
  Sweeps<Real> guarded;  ///< against folding
  /// out = own + below [N].
  void (*store_force)(const FinishPlane<Real>&);
  /// out = (own + below) / m + gravity, 0 where there is no particle [m/s^2].
  void (*store_acceleration)(const FinishPlane<Real>&);
  /// out = a M p - (own + below), 0 where there is no particle.
  void (*store_product)(const FinishPlane<Real>&);
  /// The KickDrift update in place, from own + below.
  void (*kick_drift)(const FinishPlane<Real>&);
  /// The KickDrift update in place, from an acceleration in `own`.
  void (*kick_drift_stored)(const FinishPlane<Real>&);
  void (*short_step)(const ShortStepPlane<Real>&);
};

MSS_KERNEL_COPIES(SweepKernel<float>);
MSS_KERNEL_COPIES(SweepKernel<double>);

}  // namespace mss
