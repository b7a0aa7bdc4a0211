#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/body/body.hpp"
#include "core/scene/scene.hpp"
#include "integrators/analysis/modes.hpp"

namespace mss {

/// What most of a vibration's kinetic energy is of, seen in sections across the body's longest side.
enum class SectionMotion {
  bending,       ///< sections that move sideways
  torsion,       ///< sections that turn in their plane
  longitudinal,  ///< sections that move along the side
  other          ///< none of these: sections that change their shape, or several of these
};
const char* to_string(SectionMotion motion);

/// The slowest vibrations of a body about rest, as it is held, those that move it as a whole left out.
struct Vibrations {
  std::unique_ptr<const Body> body;
  std::vector<Mode> modes;             ///< ascending
  std::vector<SectionMotion> motions;  ///< of each

  std::size_t size() const { return modes.size(); }
};

/// Of a scene's body without the planes around it; `count` of them, or as many as there are. Throws
/// InputError where its rest is no equilibrium that lasts, or for cells of several sizes.
Vibrations slowest_vibrations(const Scene& scene, int count);

/// A vibration of another body that is like one.
struct Partner {
  std::size_t mode = 0;
  double likeness = 0;  ///< 1: they move particles alike; 0: nothing is the same

  bool found() const { return likeness > 0.5; }
};

/// For each vibration of `fine` one of `coarse`, the same body in larger cells, that is like it, no two the
/// same: by the squared cosine between both in the masses of the larger cells' particles (the modal assurance
/// criterion, Allemang 2003), which is added up over coarse ones of equal frequency, because these have no
/// shapes of their own.
std::vector<Partner> partners(const Vibrations& fine, const Vibrations& coarse);

}  // namespace mss
