#pragma once

#include "core/springs/solid_system.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Scales of the local errors of adaptive methods: of positions the size of a cell, of velocities a tenth of
/// the speed at which the fastest mode would cross one. Vibrations ten times slower than that mode then have
/// errors of the same share in position and velocity. Where nothing vibrates, a cell in a second.
template <class Real>
void scale_errors(IntegratorOptions& options, const SolidSystem<Real>& system) {
  options.length_scale = system.cell_size();
  const double omega = system.spectral_bound().omega;
  options.speed_scale = options.length_scale * (omega == 0 ? 1 : omega / 10);
}

}  // namespace mss
