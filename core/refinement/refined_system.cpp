#include "core/refinement/refined_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "core/base/error.hpp"
#include "core/base/record.hpp"
#include "core/refinement/local_steps.hpp"
#include "core/springs/cell_virials.hpp"

namespace mss {

namespace {

/// What acts on a level alone: loads, and planes at the end of steps, act on the whole.
Environment of_level(const Environment& environment) {
  Environment part = environment;
  part.loads.clear();
  part.strikes.clear();
  std::erase_if(part.planes, [](const Plane& plane) { return plane.contact != ContactLaw::penalty; });
  std::erase_if(part.obstacles,
                [](const Obstacle& obstacle) { return obstacle.contact != ContactLaw::penalty; });
  return part;
}

void check(const Environment& environment) {
  const auto on_surface = [](const Load& load) { return load.surface != nullptr; };
  if (environment.contact_surface ||
      std::any_of(environment.loads.begin(), environment.loads.end(), on_surface))
    throw InputError(
        "a body with cells of several sizes carries no mesh; let planes and loads act on particles");
  const auto has_history = [](const Load& load) { return !load.history.empty(); };
  if (std::any_of(environment.loads.begin(), environment.loads.end(), has_history))
    throw InputError(
        "loads on a body with cells of several sizes are constant; leave load.history or [[refine]] out");
}

SpectralBound largest(const SpectralBound& a, const SpectralBound& b) {
  return {std::max(a.omega, b.omega), std::max(a.damping, b.damping)};
}

SpectralBound bound_of(const RefinedBody& body) {
  SpectralBound bound;
  for (const Level& level : body.levels()) bound = largest(bound, spectral_bound(level.body));
  return bound;
}

/// Those of a level in cells that touch a master of what hangs on the level.
std::size_t particles_beside_next(const RefinedBody& body, std::size_t level) {
  const Body& own = body.levels()[level].body;
  std::vector<bool> is_master(std::size_t(own.lattice().size)), beside = is_master;
  for (const HangingParticle& p : body.hanging())
    for (std::size_t m = 0; m < p.count && p.level == level + 1; ++m)
      is_master[std::size_t(p.masters[m])] = true;
  own.for_each_cell([&](std::ptrdiff_t cell) {
    bool touches = false;
    for (int c = 0; c < 8; ++c) touches = touches || is_master[std::size_t(cell + own.lattice().corner(c))];
    for (int c = 0; c < 8 && touches; ++c) beside[std::size_t(cell + own.lattice().corner(c))] = true;
  });
  return std::size_t(std::count(beside.begin(), beside.end(), true));
}

}  // namespace

void check_holds(const RefinedBody& body, const HeldSites& held) {
  for (const HangingParticle& p : body.hanging())
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t m = 0; m < p.count && held.holds(body.site_in_field(p.level, p.site), axis); ++m) {
        if (held.holds(body.site_in_field(p.level - 1, p.masters[m]), axis)) continue;
        const Vec3 at = body.levels()[p.level].body.rest_position(p.site);
        throw InputError(fmt::format(
            "a hold takes the particle at [{:.6g}, {:.6g}, {:.6g}], which follows particles of larger cells, "
            "and not all of these; make its box or the refined box larger or smaller",
            at[0], at[1], at[2]));
      }
}

template <class Real>
RefinedSystem<Real>::RefinedSystem(const RefinedBody& body, const Environment& environment,
                                   const Execution& execution)
    : body_(body),
      of_level_(of_level(environment)),
      requested_threads_(execution.threads),
      transfer_(body),
      held_(body.levels(), environment.holds),
      contact_(environment, bound_of(body), body.levels().back().body.config().cell_size),
      bounds_of_planes_(plane_bounds(environment, bound_of(body).omega,
                                     body.levels().back().body.config().cell_size, held_)),
      impulses_(contact_.has_collisions()
                    ? std::make_unique<PlaneImpulses>(contact_.collisions(), body.size())
                    : nullptr),
      tangents_(*this),
      events_(*this) {
  check(environment);
  check_holds(body, held_);
  for (const Level& level : body.levels()) {
    levels_.push_back(std::make_unique<LevelState>(level.body, of_level_, execution));
    bound_ = largest(bound_, levels_.back()->system.spectral_bound());
  }
  forces_take_velocities_ = body.config().is_damped() || contact_.has_penalties();
  find_loads(environment.loads);
}

/// Those on hanging particles are their masters'.
template <class Real>
void RefinedSystem<Real>::find_loads(const std::vector<Load>& loads) {
  Field<double> forces(size());
  LoadedSites(levels(), loads)
      .add(0, 0, size(), std::array<double*, 3>{forces.axis(0), forces.axis(1), forces.axis(2)});
  body_.scatter_to_masters(forces);
  for (std::size_t level = 0; level < levels().size(); ++level)
    for (const std::ptrdiff_t site : levels()[level].body.sites())
      if (const Vec3 force = forces.at(body_.site_in_field(level, site)); force != Vec3::Zero())
        loaded_.push_back({level, site, force, force / body_.mass(body_.site_in_field(level, site))});
}

template <class Real>
void RefinedSystem<Real>::load_state(const Field<Real>& x, const Field<Real>& v) {
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    copy_level(x, levels()[i], levels_[i]->state.x);
    copy_level(v, levels()[i], levels_[i]->state.v);
  }
  place_hanging();
}

template <class Real>
void RefinedSystem<Real>::place_hanging() {
  transfer_.interpolate([&](std::size_t level) -> Field<Real>& { return levels_[level]->state.x; });
  if (forces_take_velocities_)
    transfer_.interpolate([&](std::size_t level) -> Field<Real>& { return levels_[level]->state.v; });
}

/// Of all levels, from their positions and velocities.
template <class Real>
void RefinedSystem<Real>::accelerate(double t) {
  for (const auto& level : levels_) level->system.acceleration(t, level->state.x, level->state.v, level->a);
  for (std::size_t i = 1; i < levels_.size(); ++i)
    transfer_.scatter_accelerations_to_masters(i, levels_[i]->a, levels_[i - 1]->a);
  for (const Loaded& l : loaded_)
    for (int axis = 0; axis < 3; ++axis)
      levels_[l.level]->a.axis(axis)[l.site] += static_cast<Real>(l.acceleration[axis]);
  finish_accelerations(t);
}

template <class Real>
void RefinedSystem<Real>::finish_accelerations(double t) {
  if (contact_.has_collisions()) stop_sticking(t);
  for (const auto& level : levels_) level->system.clear_prescribed(level->a);
}

/// As BodySystem::stop_sticking().
template <class Real>
void RefinedSystem<Real>::stop_sticking(double t) {
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    LevelState& level = *levels_[i];
    for_each_particle(level.system, [&](std::ptrdiff_t site) {
      const std::ptrdiff_t at = body_.site_in_field(i, site);
      mss::stop_sticking({contact_, held_, impulses_.get()}, at, body_.mass(at), t, site, level.state.x,
                         level.state.v, level.a);
    });
  }
}

template <class Real>
void RefinedSystem<Real>::force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) {
  load_state(x, v);
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    LevelState& level = *levels_[i];
    level.system.force(t, level.state.x, level.state.v, level.a);
    copy_level(levels()[i], level.a, f);
  }
  body_.scatter_to_masters(f);
  for (const Loaded& l : loaded_)
    for (int axis = 0; axis < 3; ++axis)
      f.axis(axis)[body_.site_in_field(l.level, l.site)] += static_cast<Real>(l.force[axis]);
}

template <class Real>
void RefinedSystem<Real>::acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  load_state(x, v);
  accelerate(t);
  store_accelerations(a);
}

/// Accelerations of all particles.
template <class Real>
void RefinedSystem<Real>::store_accelerations(Field<Real>& a) {
  transfer_.interpolate([&](std::size_t level) -> Field<Real>& { return levels_[level]->a; });
  for (std::size_t i = 0; i < levels_.size(); ++i) copy_level(levels()[i], levels_[i]->a, a);
}

template <class Real>
void RefinedSystem<Real>::kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) {
  step_levels(update, dt, steps, state, [this](double t) { accelerate(t); });
}

/// With the accelerations that `accelerate` leaves in the levels.
template <class Real>
void RefinedSystem<Real>::step_levels(const KickDrift& update, double dt, long steps, State<Real>& state,
                                      const std::function<void(double)>& accelerate) {
  load_state(state.x, state.v);
  for (long step = 0; step < steps; ++step) {
    const double t = state.t + double(step) * dt;
    accelerate(t);
    for (const auto& level : levels_) {
      level->state.t = t;
      level->system.apply(update, level->a, dt, level->state);
    }
    kicked_for(*this, update.kick_before + update.kick_after);
    place_hanging();
  }
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    copy_level(levels()[i], levels_[i]->state.x, state.x);
    copy_level(levels()[i], levels_[i]->state.v, state.v);
  }
  body_.interpolate(state.v);
  state.t += double(steps) * dt;
}

template <class Real>
void RefinedSystem<Real>::constrain(double t, Field<Real>& x, Field<Real>& v) const {
  held_.apply(t, 0, size(), x, v);
  body_.interpolate(x);
  body_.interpolate(v);
}

template <class Real>
void RefinedSystem<Real>::clear_prescribed(Field<Real>& field) const {
  held_.clear(field);
  for (const HangingParticle& p : body_.hanging())
    for (int axis = 0; axis < 3; ++axis) field.axis(axis)[body_.site_in_field(p.level, p.site)] = 0;
}

/// The level that most threads pay for.
template <class Real>
SpringSystem<Real>& RefinedSystem<Real>::most_threaded() const {
  const auto most = std::max_element(levels_.begin(), levels_.end(), [](const auto& a, const auto& b) {
    return a->system.threads() < b->system.threads();
  });
  return (*most)->system;
}

template <class Real>
void RefinedSystem<Real>::parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) {
  most_threaded().parallel(count, task);
}

template <class Real>
double RefinedSystem<Real>::threads_working() const {
  return most_threaded().threads_working();
}

template <class Real>
LocalStepPlan RefinedSystem<Real>::local_step_plan() const {
  std::vector<LevelCost> costs;
  for (std::size_t i = 0; i < levels_.size(); ++i)
    costs.push_back({body_.depth(i), levels()[i].body.particle_count(), particles_beside_next(body_, i),
                     levels_[i]->system.spectral_bound()});
  return plan_local_steps(costs);
}

template <class Real>
SpectralBound RefinedSystem<Real>::local_bound() const {
  return {.omega = 2 / local_step_plan().largest_step};
}

template <class Real>
std::unique_ptr<System<Real>> RefinedSystem<Real>::with_local_steps(double dt) {
  return std::make_unique<LocalSteps<Real>>(*this, of_level_, dt, requested_threads_);
}

template <class Real>
int RefinedSystem<Real>::threads() const {
  return most_threaded().threads();
}

template <class Real>
const SweepKernel<Real>& RefinedSystem<Real>::kernel() const {
  return levels_.front()->system.kernel();
}

template <class Real>
const char* RefinedSystem<Real>::kernel_name() const {
  return levels_.front()->system.kernel_name();
}

template <class Real>
template <class Visit>
void RefinedSystem<Real>::for_each_level(const Field<Real>& x, Visit&& visit) const {
  Field<Real> whole = x;
  body_.interpolate(whole);
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    Field<Real> part(levels_[i]->system.size());
    copy_level(whole, levels()[i], part);
    visit(levels_[i]->system, part);
  }
}

template <class Real>
StoredEnergy RefinedSystem<Real>::stored_energy(const Field<Real>& x) const {
  StoredEnergy sum;
  for_each_level(x, [&](const SpringSystem<Real>& system, const Field<Real>& part) {
    const StoredEnergy energy = system.stored_energy(part);
    sum.elastic += energy.elastic;
    sum.volume += energy.volume;
  });
  return sum;
}

template <class Real>
std::optional<std::vector<Eigen::Matrix3d>> RefinedSystem<Real>::cell_virials(const Field<Real>& x,
                                                                              const Field<Real>& v) const {
  std::vector<Eigen::Matrix3d> virials;
  for (const Level& level : levels()) append_virials(level, x, v, virials);
  return virials;
}

template <class Real>
double RefinedSystem<Real>::outer_potential(double t, const Field<Real>& x) const {
  double sum = 0;
  for (const Loaded& l : loaded_) sum -= l.force.dot(x.at(body_.site_in_field(l.level, l.site)));
  for_each_level(x, [&](const SpringSystem<Real>& system, const Field<Real>& part) {
    sum += system.outer_potential(t, part);
  });
  return sum;
}

template <class Real>
void RefinedSystem<Real>::add_penalty_forces(const State<Real>& state, std::vector<Wrench>& forces) const {
  if (!contact_.has_penalties()) return;
  State<Real> whole = state;
  body_.interpolate(whole.x);
  body_.interpolate(whole.v);
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    State<Real> part = levels_[i]->state;
    copy_level(whole.x, levels()[i], part.x);
    copy_level(whole.v, levels()[i], part.v);
    levels_[i]->system.add_penalty_forces(part, forces);
  }
}

template <class Real>
bool RefinedSystem<Real>::Events::collide(const State<Real>& before, double dt, State<Real>& state) {
  const Colliding colliding{system_.contact_, system_.held_, system_.impulses_.get()};
  if (colliding.impulses) colliding.impulses->end_step(dt);
  std::atomic<bool> any{false};
  for_each_particle(system_, [&](std::ptrdiff_t site) {
    if (collide_particle(colliding, site, system_.mass(site), before, dt, state))
      any.store(true, std::memory_order_relaxed);
  });
  if (any) system_.constrain(state.t, state.x, state.v);
  return any;
}

/// Its levels keep nothing: planes act on the whole, and nothing sleeps.
template <class Real>
void RefinedSystem<Real>::remember(Record& record) {
  if (impulses_) record.keep(*impulses_);
}

template class RefinedSystem<float>;
template class RefinedSystem<double>;

}  // namespace mss
