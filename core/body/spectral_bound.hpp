#pragma once

#include <vector>

#include "core/body/body.hpp"

namespace mss {

/// Upper bounds on the spectrum of a body about its rest state: for every mode of
///   M x'' = -K x - C x'
/// w^2 = (x.K x)/(x.M x) <= omega^2 and (x.C x)/(x.M x) <= damping.
struct SpectralBound {
  double omega = 0;    ///< [rad/s]
  double damping = 0;  ///< [1/s]
};

/// Block Gershgorin bound; of springs that relax it is of their stiffness at once. For a spring with
/// direction u, (u.(x_j - x_i))^2 <= 2 (u.x_i)^2 + 2 (u.x_j)^2, and for a cell's volume there are eight such
/// terms, so K is below the block-diagonal matrix of 2 sum k u u^T
/// + 8 k_vol/V0 g g^T with g the volume's gradient, and omega^2 is below the largest eigenvalue of a block
/// over its mass. For the `uniform` cube that is the corner's sqrt(16 (k_e + 2 k_f + k_c) / (rho h^3)).
SpectralBound spectral_bound(const Body& body);

/// The same with a guard against folding that acts everywhere, though at rest it acts nowhere: at the
/// three edges of each corner of a cell, two corners an edge, it adds 12 guarded_corner_stiffness() to a
/// block. Steps that must be stable under strong compression need this.
SpectralBound guarded_spectral_bound(const Body& body);

/// The bound of a solid of several lattices, and what a guard that acts everywhere adds to it at most.
SpectralBound with_guard(const SpectralBound& bound, const std::vector<Level>& levels);

}  // namespace mss
