#pragma once

#include "experiments/studies/reduce/movers.hpp"

namespace mss::studies::reduce {

// Models that lose against lattices in larger cells, so that charts show by how much.

/// Affine motions of a few control points along a clamped body, blended linearly between these (Faure,
/// Gilles, Bousquet and Pai, ACM TOG 30 (2011) 73: of an even bar their weights are linear), with the
/// polynomial force of models "modal_cubic" in that subspace. `matched`: with the E that makes the slowest
/// vibration the body's.
std::unique_ptr<Mover> frames_mover(const ReduceScene& scene, const Solid& solid, const LatticeChoice& own,
                                    int points, bool matched, const State<double>& start);

/// Shape matching with regions of one size.
struct ShapeRegions {
  int width = 2;     ///< as `solve.region_width`
  int steps = 1;     ///< a frame
  double alpha = 1;  ///< share of the way to the goal in a step
};
std::unique_ptr<Mover> shape_mover(const ReduceScene& scene, const Solid& solid, const LatticeChoice& lattice,
                                   const ShapeRegions& regions, const Body& body);

/// The same on the body's own lattice with regions that grow away from the clamp, cells of an octree with
/// half of their size around them (Steinemann, Otaduy and Gross, SCA 2008, 87), and sums over each region
/// taken as they stand. `steps` and `alpha` as above. Under gravity.
std::unique_ptr<Mover> adaptive_shape_mover(const ReduceScene& scene, const Solid& solid, const Body& body,
                                            const State<double>& start, int steps, double alpha);

}  // namespace mss::studies::reduce
