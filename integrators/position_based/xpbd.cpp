// Extended position-based dynamics (Macklin, Mueller and Chentanez, MIG 2016): positions move as they would
// without springs, then every spring and every cell's volume moves its own particles towards its rest state,
// one after the other, as a constraint whose compliance is the inverse of its stiffness; velocities follow
// from positions:
//   u = dt v_n + dt^2 M^-1 f_outer,   projections (integrators/position_based/xpbd_kernel.hpp), in
//   `solve.iterations` passes, x_{n+1} = x_n + u,   v_{n+1} = u / dt.
// One pass a step, with small steps, is the method of Macklin et al., Small steps in physics simulation, SCA
// 2019: as dt goes to 0 it is semi-implicit Euler in another order. More passes keep multipliers; they tend
// to backward Euler without the springs' geometric stiffness, which is not quite backward Euler. Every
// projection keeps linear momentum. Stable at any step; loses energy, but on
// planes few passes of a stiff body gain it.
#include "integrators/device/on_device.hpp"
#include "integrators/position_based/position_based_integrator.hpp"
#include "integrators/position_based/xpbd_solver.hpp"

namespace mss {

namespace {

template <class Real>
std::unique_ptr<XpbdSolver<Real>> make_passes(const SpringSystem<Real>& springs, System<Real>& system,
                                              const IntegratorOptions& options) {
  check_local_solutions(springs.body().config(), "xpbd");
  return std::make_unique<XpbdSolver<Real>>(springs, system, options.dt, options.iterations > 1);
}

template <class Real>
std::unique_ptr<Integrator<Real>> make(const IntegratorOptions& options) {
  return std::make_unique<PositionBasedIntegrator<Real, XpbdSolver<Real>>>(options, "xpbd",
                                                                           make_passes<Real>);
}

}  // namespace

IntegratorInfo xpbd() {
  return on_device(
      DeviceSteps::xpbd,
      IntegratorInfo{.name = "xpbd",
                     .summary = "extended position-based dynamics: a pass over all springs a step, or "
                                "`iterations`; first order, any step; few passes lose energy in motion and "
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
