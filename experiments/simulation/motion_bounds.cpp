#include "experiments/simulation/motion_bounds.hpp"

#include <algorithm>
#include <cmath>

#include "experiments/simulation/outcome.hpp"

namespace mss {

MotionWatch::MotionWatch(const MovingBody& body, double velocity_lag)
    : body_(body), velocity_lag_(velocity_lag) {
  const Measures m = measure(body.system, body.start);
  first_potential_ = m.external_potential;
  extremes_.first_energy = extremes_.energy = m.mechanical();
  extremes_.min_jacobian = m.min_jacobian;
}

void MotionWatch::add(const State<double>& state) {
  const Measures m = measure_in_time(body_.system, state, velocity_lag_);
  MotionExtremes& e = extremes_;
  // Not std::max, which passes over NaN.
  e.energy = m.mechanical() <= e.energy ? e.energy : m.mechanical();
  e.work = std::max(e.work, first_potential_ - m.external_potential);
  e.displacement = std::max(e.displacement, std::sqrt(body_.squared_distance(state.x, body_.start.x) /
                                                      double(body_.body.particle_count())));
  e.min_jacobian = std::min(e.min_jacobian, m.min_jacobian);
  for (const Plane& plane : body_.system.environment().planes)
    for (const std::ptrdiff_t site : body_.body.sites())
      e.depth = std::max(e.depth, -plane.gap(state.x.at(site)));
}

double supplied_energy(const MotionExtremes& truth) { return truth.first_energy + truth.work; }

std::string out_of_bounds(const MotionExtremes& run, const MotionExtremes& truth, double cell_size) {
  if (!(run.energy <= bounded_factor * supplied_energy(truth))) return "energy";
  if (!(run.displacement <= bounded_factor * truth.displacement)) return "displacement";
  if (run.depth > bounded_depth * cell_size) return "behind a plane";
  if (run.min_jacobian <= 0 && truth.min_jacobian > 0) return "folded";
  return {};
}

}  // namespace mss
