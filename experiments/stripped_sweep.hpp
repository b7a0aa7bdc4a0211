#pragma once

#include <optional>

#include "core/sweep.hpp"

namespace mss {

/// What a sweep has been stripped of.
enum class Stripped {
  choice,
  damping,
  volume_force,
  body_diagonals,
  face_diagonals,
  all_but_edges_and_faces
};

/// The fastest kernel with a sweep that holds one kind of cell only, written down by hand: what SpringSystem
/// chooses at run time should not be slower. `choice`: all of an unguarded cell, and nothing to choose from.
/// Nothing if there is none for this processor.
template <class Real>
std::optional<SweepKernel<Real>> stripped_kernel(Stripped of);

}  // namespace mss
