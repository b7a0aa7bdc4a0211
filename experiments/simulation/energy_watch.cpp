#include "experiments/simulation/energy_watch.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "experiments/simulation/outcome.hpp"

namespace mss {

namespace {

/// Energy that rounding of positions makes: of the fastest motion, that far.
template <class Real>
double energy_of_rounding(const SolidSystem<Real>& system, const Scene& scene, double potential) {
  constexpr double rounding = 64 * double(std::numeric_limits<Real>::epsilon());
  const Box box = box_at_rest(scene);
  const double reach = box.lower.norm() + (box.upper - box.lower).norm();
  const double speed = rounding * reach * system.spectral_bound().omega;
  return system.total_mass() * speed * speed + rounding * std::abs(potential);
}

}  // namespace

template <class Real>
EnergyWatch<Real>::EnergyWatch(const Scene& scene)
    : scene_(scene),
      method_(find_integrator(scene.solve.integrator)),
      watches_(method_.stepping != Stepping::equilibrium && method_.has_modulus &&
               scene.model != mollemans_model) {}

/// Whether holds or obstacles that move or loads that change work on the body at a time, or later.
template <class Real>
bool EnergyWatch<Real>::is_driven(double t) const {
  const auto& [holds, loads] = std::tie(scene_.environment.holds, scene_.environment.loads);
  const std::vector<Obstacle>& obstacles = scene_.environment.obstacles;
  return std::any_of(obstacles.begin(), obstacles.end(),
                     [&](const Obstacle& obstacle) { return obstacle.moves(t); }) ||
         std::any_of(holds.begin(), holds.end(), [&](const Hold& hold) { return hold.moves(t); }) ||
         std::any_of(loads.begin(), loads.end(), [&](const Load& load) { return load.history.changes(t); });
}

/// Leapfrog keeps, of small motions and exactly, an energy with the kinetic part v- M v+ / 2 of the
/// velocities half a step before and after: v and v + dt a where velocities lag (outcome.hpp), v -+ dt a / 2
/// elsewhere. That of v alone swings about it, at the limit of stability as much as it is large.
template <class Real>
double EnergyWatch<Real>::centred_total(SceneRun<Real>& run, const Measures& row) const {
  if (!method_.symplectic || method_.implicit || method_.order_undamped > 2) return row.total();
  SolidSystem<Real>& system = run.system();
  const State<Real>& state = run.state();
  Field<Real> a(system.size());
  system.acceleration(state.t, state.x, state.v, a);
  const bool lags = velocity_lag(method_, run.dt()) > 0;
  double kinetic = 0;
  system.ranks().add_in_order(kinetic, [&] {
    for (const std::ptrdiff_t site : system.particles()) {
      const Vec3 v = state.v.at(site), change = run.dt() * a.at(site);
      const double product = lags ? v.dot(v + change) : v.squaredNorm() - change.squaredNorm() / 4;
      kinetic += system.mass(site) * product / 2;
    }
  });
  return row.total() - row.kinetic + kinetic;
}

template <class Real>
void EnergyWatch<Real>::add(SceneRun<Real>& run, const Measures& row, bool is_lifted) {
  if (!watches_) return;
  if (is_driven(row.t)) return start_.reset();
  if (is_lifted) return;
  if (!start_) {
    start_ = {row.total(), row.external_potential, run.struck(),
              energy_of_rounding(run.system(), scene_, row.external_potential)};
    at_play_ = 0;
  }
  at_play_ = std::max(at_play_, row.mechanical() + std::max(0.0, start_->potential - row.external_potential));
  const double supplied = start_->total + run.struck() - start_->struck;
  const double tolerated = SampledRun::tolerated_growth * at_play_ + start_->noise;
  if (!(row.total() - supplied > tolerated)) return;
  const double gained = std::min(row.total(), centred_total(run, row)) - supplied;
  if (gained > tolerated && (!gain_ || gained > gain_->gained)) gain_ = {row.t, gained, at_play_};
}

template class EnergyWatch<float>;
template class EnergyWatch<double>;

}  // namespace mss
