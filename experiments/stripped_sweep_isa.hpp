#pragma once

// Sweeps of one kind of cell. Included once per instruction set, as core/sweep_kernel.hpp is.

#include "core/sweep_kernel.hpp"
#include "experiments/stripped_sweep.hpp"

namespace mss::MSS_ISA {

/// Cells with that content, the upper faces of their body, and sites without any.
template <class Block, std::uint32_t Content, class Real>
void sweep_only(SweepPlane<Real>& argument) {
  constexpr int W = lanes<Real>;
  constexpr std::uint32_t faces = Content & (block_edges | block_faces);
  const SweepPlane<Real> p = argument;
  Carry<Real> carry = carry_in(p);
  for (std::ptrdiff_t b = p.first_block; b < p.last_block; ++b) {
    const std::uint32_t entry = p.entry[b];
    const Real* coefficient = coefficients_of(p, entry);
    switch (p.content[entry]) {
      case 0:
        do_block<Block, 0>(p, b * W, coefficient, carry);
        break;
      case faces:
        do_block<Block, faces>(p, b * W, coefficient, carry);
        break;
      default:
        do_block<Block, Content>(p, b * W, coefficient, carry);
    }
  }
  carry_out(carry, argument);
}

template <class Real>
Sweep<Real> stripped_sweep(Stripped of) {
  constexpr std::uint32_t faces = block_edges | block_faces, all = faces | block_bodies | block_volumes;
  switch (of) {
    case Stripped::damping:
      return sweep_only<Force<Real, false>, all, Real>;
    case Stripped::volume_force:
      return sweep_only<Force<Real, true>, faces | block_bodies, Real>;
    case Stripped::body_diagonals:
      return sweep_only<Force<Real, true>, faces | block_volumes, Real>;
    case Stripped::face_diagonals:
      return sweep_only<Force<Real, true>, block_edges | block_bodies | block_volumes, Real>;
    case Stripped::all_but_edges_and_faces:
      return sweep_only<Force<Real, false>, faces, Real>;
    case Stripped::choice:
      break;
  }
  return sweep_only<Force<Real, true>, all, Real>;
}

}  // namespace mss::MSS_ISA
