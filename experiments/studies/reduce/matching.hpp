#pragma once

#include <optional>

#include "experiments/studies/reduce/scenes.hpp"

namespace mss::studies::reduce {

/// Which slowest vibrations a lattice shares with the body that it stands for.
enum class Matched {
  nothing,
  bending,  ///< by E; of a free body the slowest elastic one
  torsion,  ///< by E
  both      ///< by E and nu
};

/// Slowest vibrations [rad/s]; of a free body only the slowest, as `bending`.
struct SlowVibrations {
  double bending = 0, torsion = 0;
};
/// Throws std::runtime_error if they are not found.
SlowVibrations slow_vibrations(const Solid& solid, const LatticeChoice& lattice);

/// The lattice with the moduli that give it vibrations as slow as those; nothing where no moduli do.
std::optional<LatticeChoice> matched(const Solid& solid, LatticeChoice lattice, Matched of,
                                     const SlowVibrations& wanted);

}  // namespace mss::studies::reduce
