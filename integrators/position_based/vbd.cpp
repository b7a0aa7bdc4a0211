// Vertex block descent (Chen, Liu, Yang and Yuksel, ACM TOG 43 (2024) 116): a step of backward Euler as the
// minimum of kinetic and stored energy, sought particle by particle
// (integrators/position_based/vbd_kernel.hpp), in `solve.iterations` passes from x_n + dt v_n + dt^2 a, a
// what gravity made of the last step:
//   x_{n+1} = x_n + u,   v_{n+1} = u / dt.
// With enough passes it is backward Euler; with few it is softer, more damped, and does not keep linear
// momentum, because the last particle moves among neighbours that have moved already. Stable at any step.
// `solve.chebyshev_radius` rho > 0 adds Chebyshev's semi-iteration, for rho the spectral radius of a pass;
// too large a rho makes passes diverge.
#include "integrators/device/on_device.hpp"
#include "integrators/position_based/position_based_integrator.hpp"
#include "integrators/position_based/vbd_solver.hpp"

namespace mss {

namespace {

template <class Real>
std::unique_ptr<VbdSolver<Real>> make_passes(const SpringSystem<Real>& springs, System<Real>& system,
                                             const IntegratorOptions& options) {
  check_local_solutions(springs.body().config(), "vbd");
  return std::make_unique<VbdSolver<Real>>(springs, system, options.dt, options.chebyshev_radius);
}

template <class Real>
std::unique_ptr<Integrator<Real>> make(const IntegratorOptions& options) {
  return std::make_unique<PositionBasedIntegrator<Real, VbdSolver<Real>>>(options, "vbd", make_passes<Real>);
}

}  // namespace

IntegratorInfo vbd() {
  return on_device(
      DeviceSteps::vbd,
      IntegratorInfo{.name = "vbd",
                     .summary = "vertex block descent: a pass over all particles a step, or `iterations`, "
                                "towards backward Euler; any step; few passes lose energy in motion and "
                                "gain it on planes",
                     .order_undamped = 1,
                     .order_damped = 1,
                     .collisions = Collisions::inside_steps,
                     .iterates = true,
                     .springs_only = true,
                     .variants = {":5", ":20"},
                     .make_single = make<float>,
                     .make_double = make<double>},
      check_local_solutions);
}

}  // namespace mss
