// Lattices in large cells whose slowest vibrations are those of small ones.
#include "experiments/studies/reduce/matching.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "integrators/analysis/modes.hpp"

namespace mss::studies::reduce {

namespace {

/// How far the end face moves across, and whether as a whole, in a vibration: over its largest displacement.
double end_motion(const Solid& solid, const Body& body, const Field<double>& shape) {
  double largest = 0;
  for (const std::ptrdiff_t site : body.sites()) largest = std::max(largest, shape.at(site).norm());
  Vec3 sum = Vec3::Zero();
  const std::vector<std::ptrdiff_t> face = body.select({solid.size[0], 0, 0}, solid.size);
  for (const std::ptrdiff_t site : face) sum += shape.at(site);
  return std::hypot(sum[1], sum[2]) / double(face.size()) / largest;
}

}  // namespace

SlowVibrations slow_vibrations(const Solid& solid, const LatticeChoice& lattice) {
  constexpr int count = 7;  // of a free body the seventh is the first elastic one
  const Scene scene = scene_on({}, solid, lattice);
  const Body body(scene.body);
  const auto system = make_system<double>(spring_model, body, scene.environment, 1);
  Work work;
  const Modes found = slowest_modes(*system, system->rest_state(), count, work);
  if (found.status != Status::ok) throw std::runtime_error("the vibrations of a body are not found");
  if (!solid.clamped) return {.bending = found.modes.back().omega};
  SlowVibrations slow;
  for (const Mode& mode : found.modes) {
    const double across = end_motion(solid, body, mode.shape);
    if (across > 0.3 && slow.bending == 0) slow.bending = mode.omega;
    if (across < 1e-3 && slow.torsion == 0) slow.torsion = mode.omega;
  }
  return slow;
}

std::optional<LatticeChoice> matched(const Solid& solid, LatticeChoice lattice, Matched of,
                                     const SlowVibrations& wanted) {
  const auto squared = [](double ratio) { return ratio * ratio; };
  if (of == Matched::nothing) return lattice;
  if (of != Matched::both) {
    const SlowVibrations own = slow_vibrations(solid, lattice);
    lattice.young *= of == Matched::bending ? squared(wanted.bending / own.bending)
                                            : squared(wanted.torsion / own.torsion);
    return std::isfinite(lattice.young) ? std::optional(lattice) : std::nullopt;
  }
  constexpr int rounds = 30;
  constexpr double share = 0.8, close = 1e-5, least_poisson = -0.5, most_poisson = 0.48;
  double shear = lattice.young / (2 * (1 + lattice.poisson));
  for (int i = 0; i < rounds; ++i) {
    const SlowVibrations own = slow_vibrations(solid, lattice);
    const double bending = squared(wanted.bending / own.bending),
                 torsion = squared(wanted.torsion / own.torsion);
    if (std::abs(bending - 1) + std::abs(torsion - 1) < close) return lattice;
    lattice.young *= std::pow(bending, share);
    shear *= std::pow(torsion, share);
    lattice.poisson = std::clamp(lattice.young / (2 * shear) - 1, least_poisson, most_poisson);
  }
  return std::nullopt;
}

}  // namespace mss::studies::reduce
