#include "experiments/simulation/disturbance.hpp"

#include <random>

namespace mss {

Field<double> fast_disturbance(BodySystem<double>& system, const State<double>& equilibrium, double largest,
                               std::uint64_t seed) {
  constexpr double small = 1e-6;  // of a cell: forces are linear in it
  constexpr int rounds = 2;
  const double while_small = small * system.body().config().cell_size;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<> place(-1, 1);
  Field<double> off(system.size()), x(system.size()), residual(system.size());
  for (const std::ptrdiff_t site : system.particles()) {
    const double a = place(random), b = place(random), c = place(random);
    off.set(site, {a, b, c});
  }
  system.acceleration(equilibrium.t, equilibrium.x, equilibrium.v, residual);
  for (int round = 0; round < rounds; ++round) {
    off.array() *= while_small / off.array().abs().maxCoeff();
    x.array() = equilibrium.x.array() + off.array();
    system.acceleration(equilibrium.t, x, equilibrium.v, off);
    off.array() -= residual.array();
  }
  off.array() *= largest / off.array().abs().maxCoeff();
  return off;
}

}  // namespace mss
