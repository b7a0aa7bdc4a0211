#include "experiments/simulation/equilibrium.hpp"

namespace mss {

Equilibrium find_equilibrium(BodySystem<double>& system, const std::function<Vec3(const Vec3& rest)>& guess) {
  Equilibrium e{.state = system.undeformed_state()};
  for (const std::ptrdiff_t site : system.particles())
    e.state.x.set(site, guess(system.body().rest_position(site)));
  Work work;
  e.status = find_integrator("static").make<double>({})->advance(system, e.state, 1, work);
  return e;
}

}  // namespace mss
