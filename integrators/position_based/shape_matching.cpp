// Shape matching (integrators/position_based/shape_matching_solver.hpp): a step moves every particle as far
// as it would go without forces between particles, and by a share of the way to where its regions, as rigid
// bodies, would have it:
//   u = dt v_n + dt^2 M^-1 f_outer + alpha (goal(x_n) - x_n),   x_{n+1} = x_n + u,   v_{n+1} = u / dt,
// Mueller, Heidelberger, Teschner and Gross, ACM TOG 24 (2005) 471, eq. 10 and 11. There are no springs in
// it: `solve.region_width` and `solve.alpha` make a body stiff or soft, not Young's modulus. At rest
// alpha (goal - x) = -dt^2 a, so how far it hangs through depends on alpha / dt^2. Double precision only:
// what rounding does to a goal is divided by dt, and in single precision a free body drifts.
#include "integrators/position_based/position_based_integrator.hpp"
#include "integrators/position_based/shape_matching_solver.hpp"

namespace mss {

namespace {

std::unique_ptr<ShapeMatching> make_passes(const SpringSystem<double>& springs, System<double>& system,
                                           const IntegratorOptions& options) {
  check_regions(springs.body().config(), "shape_matching");
  return std::make_unique<ShapeMatching>(springs, system, options.dt, options.region_width, options.alpha);
}

/// One pass a step: goals follow from where particles were at its beginning.
std::unique_ptr<Integrator<double>> make(IntegratorOptions options) {
  options.iterations = 1;
  return std::make_unique<PositionBasedIntegrator<double, ShapeMatching>>(options, "shape_matching",
                                                                          make_passes);
}

}  // namespace

IntegratorInfo shape_matching() {
  return {
      .name = "shape_matching",
      .summary =
          "lattice shape matching: regions return to their rest shapes; no springs and no modulus, any step",
      .order_undamped = 0,
      .order_damped = 0,
      .collisions = Collisions::inside_steps,
      .springs_only = true,
      .has_modulus = false,
      .make_double = make};
}

}  // namespace mss
