#include "experiments/simulation/motion_bounds.hpp"

#include <algorithm>
#include <cmath>

namespace mss {

MotionWatch::MotionWatch(const MovingBody& body, double velocity_lag)
    : body_(body), velocity_lag_(velocity_lag) {
  const Measures m = measure(body.system, body.start);
  first_potential_ = m.external_potential;
  extremes_.first_energy = extremes_.energy = m.mechanical();
  extremes_.min_jacobian = m.min_jacobian;
}

Measures MotionWatch::measured(const State<double>& state) const {
  if (velocity_lag_ == 0) return measure(body_.system, state);
  State<double> in_time = state;
  body_.system.acceleration(state.t, state.x, state.v, in_time.v);
  in_time.v.array() = state.v.array() + velocity_lag_ * in_time.v.array();
  return measure(body_.system, in_time);
}

void MotionWatch::add(const State<double>& state) {
  const Measures m = measured(state);
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
