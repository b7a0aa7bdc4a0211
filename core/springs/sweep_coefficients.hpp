#pragma once

#include <cstdint>
#include <vector>

#include "core/kernels/sweep.hpp"
#include "core/springs/sweep_blocks.hpp"

namespace mss {

/// What a sweep reads of a body beside positions and velocities: the weights of springs and cells, block by
/// block, and what they multiply. Blocks with equal sites share an entry of a dictionary: a large box has a
/// few dozen.
template <class Real>
class SweepCoefficients {
 public:
  /// The body must outlive them.
  SweepCoefficients(const Body& body, const SweepBlocks& blocks, const SweepKernel<Real>& kernel);

  /// Tells a sweep of blocks from `first_block` on; without `springs` as if there were cells alone.
  void describe(std::size_t first_block, bool springs, SweepPlane<Real>& p) const;
  /// The leanest sweep for forces that this body needs.
  Sweep<Real> force_sweep(const Sweeps<Real>& sweeps) const;

 private:
  InteriorCoefficients<Real> interior_coefficients() const;
  bool has_cell_weights() const;
  static std::uint32_t content_of(const SiteElements& e);
  std::uint32_t content_of_all_kinds() const;
  std::uint32_t fill_lane(std::uint32_t kind, Real* coefficients) const;
  void build_dictionary(const SweepBlocks& blocks);

  const Body& body_;
  int lanes_;
  Real rsqrt_scale_;
  bool own_dampings_, cell_weights_;  ///< what a block's coefficients contain beside weights
  InteriorCoefficients<Real> interior_;
  std::vector<std::uint32_t> entry_;    ///< per block, and two more: dictionary entry
  std::vector<std::uint32_t> content_;  ///< per entry
  std::uint32_t whole_content_ = 0;     ///< of all entries together
  AlignedArray<Real> dictionary_;
};

}  // namespace mss
