#include "core/bodies/bodies_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/record.hpp"
#include "core/bodies/bodies_tangents.hpp"

namespace mss {

namespace {

template <class Real>
std::vector<Level> levels_of(const typename BodiesSystem<Real>::Bodies& bodies) {
  std::vector<Level> levels;
  std::ptrdiff_t first = 0;
  for (const auto& body : bodies) {
    levels.push_back({body->body(), first});
    first += body->size();
  }
  return levels;
}

template <class Real>
SpectralBound largest_bound(const typename BodiesSystem<Real>::Bodies& bodies, bool with_planes) {
  SpectralBound bound;
  for (const auto& body : bodies) {
    const SpectralBound of_body = with_planes ? body->spectral_bound() : body->body_bound();
    bound.omega = std::max(bound.omega, of_body.omega);
    bound.damping = std::max(bound.damping, of_body.damping);
  }
  return bound;
}

double smallest_cell(const std::vector<Level>& levels) {
  double smallest = levels.front().body.config().cell_size;
  for (const Level& level : levels) smallest = std::min(smallest, level.body.config().cell_size);
  return smallest;
}

template <class Real>
bool have_memory(const typename BodiesSystem<Real>::Bodies& bodies) {
  return std::any_of(bodies.begin(), bodies.end(),
                     [](const auto& body) { return body->memory() != nullptr; });
}

}  // namespace

BodyThreads threads_of(const std::vector<const Body*>& bodies, int requested) {
  std::size_t springs = 0;
  for (const Body* body : bodies) springs += body->spring_count();
  const int worth_it = int(std::min<std::size_t>(springs / 2000, 1024));
  const int together = requested > 0 ? requested : std::clamp(worth_it, 1, available_cores());
  return bodies.size() >= std::size_t(together) ? BodyThreads{1, together} : BodyThreads{requested, together};
}

Environment environment_of_body(const Environment& environment, std::shared_ptr<const TriangleMesh> surface) {
  Environment part = environment;
  part.loads.clear();
  part.strikes.clear();
  std::erase_if(part.planes, [](const Plane& plane) { return plane.contact != ContactLaw::penalty; });
  std::erase_if(part.obstacles,
                [](const Obstacle& obstacle) { return obstacle.contact != ContactLaw::penalty; });
  part.contact_surface = std::move(surface);
  part.contact = {};
  return part;
}

template <class Real>
BodiesSystem<Real>::Part::Part(std::unique_ptr<BodySystem<Real>> body_system)
    : system(std::move(body_system)),
      state{0, Field<Real>(system->size()), Field<Real>(system->size())},
      a(system->size()) {}

template <class Real>
BodiesSystem<Real>::BodiesSystem(Bodies bodies, const Environment& environment, const Surfaces& surfaces,
                                 int threads)
    : levels_(levels_of<Real>(bodies)),
      gravity_(environment.gravity),
      held_(levels_, environment.holds),
      loads_(levels_, environment.loads),
      of_bodies_(largest_bound<Real>(bodies, false)),
      cell_size_(smallest_cell(levels_)),
      contact_(environment, of_bodies_, cell_size_),
      bounds_of_planes_(plane_bounds(environment, of_bodies_.omega, cell_size_, held_)),
      team_(threads),
      bound_(largest_bound<Real>(bodies, true)),
      remembers_(have_memory<Real>(bodies)),
      events_(*this),
      memory_(*this) {
  check(environment, surfaces);
  for (auto& body : bodies) {
    for (const std::ptrdiff_t site : body->particles()) sites_.push_back(size_ + site);
    size_ += body->size();
    parts_.push_back(std::make_unique<Part>(std::move(body)));
  }
  if (contact_.has_collisions()) impulses_ = std::make_unique<PlaneImpulses>(contact_.collisions(), size_);
  if (environment.contact.acts()) make_contact(environment.contact, surfaces);
  if (std::all_of(parts_.begin(), parts_.end(), [](const auto& part) { return part->system->tangents(); }))
    tangents_ = std::make_unique<BodiesTangents<Real>>(*this);
}

template <class Real>
BodiesSystem<Real>::~BodiesSystem() = default;

template <class Real>
void BodiesSystem<Real>::check(const Environment& environment, const Surfaces& surfaces) const {
  const bool on_mesh =
      std::any_of(surfaces.begin(), surfaces.end(), [](const auto& mesh) { return mesh != nullptr; });
  if (on_mesh && contact_.has_collisions())
    throw InputError(
        "planes and obstacles of contact = \"impulse\" touch the particles of several bodies; give "
        "contact_on = "
        "\"particles\", or contact = \"penalty\"");
  const auto on_surface = [](const Load& load) { return load.surface != nullptr; };
  if (std::any_of(environment.loads.begin(), environment.loads.end(), on_surface))
    throw InputError("loads on several bodies act on particles; give load.box in place of surface_box");
  for (const Level& level : levels_)
    if (environment.contact.acts() && !level.body.config().is_solid())
      throw InputError(
          fmt::format("contact between bodies is of surfaces, and {} has none; give body.cells of three "
                      "dimensions, or leave [contact] out",
                      level.body.config().noun()));
}

template <class Real>
void BodiesSystem<Real>::make_contact(const BodyContact& rules, const Surfaces& surfaces) {
  std::vector<ContactForces::Toucher> touchers;
  for (std::size_t i = 0; i < parts_.size(); ++i)
    touchers.push_back({&levels_[i].body, i < surfaces.size() ? surfaces[i].get() : nullptr,
                        parts_[i]->system->body_bound().omega});
  forces_ = std::make_unique<ContactForces>(touchers, rules, team_);
  bound_.omega = std::sqrt(bound_.omega * bound_.omega +
                           (ContactForces::with_contact(rules) - 1) * of_bodies_.omega * of_bodies_.omega);
  remembers_ = true;
}

template <class Real>
std::vector<const Field<Real>*> BodiesSystem<Real>::positions() const {
  std::vector<const Field<Real>*> all;
  for (const auto& part : parts_) all.push_back(&part->state.x);
  return all;
}

template <class Real>
std::vector<Field<Real>*> BodiesSystem<Real>::accelerations() const {
  std::vector<Field<Real>*> all;
  for (const auto& part : parts_) all.push_back(&part->a);
  return all;
}

template <class Real>
void BodiesSystem<Real>::load_state(const Field<Real>& x, const Field<Real>& v) {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    copy_level(x, levels_[i], parts_[i]->state.x);
    copy_level(v, levels_[i], parts_[i]->state.v);
  }
}

template <class Real>
void BodiesSystem<Real>::load_positions(const Field<Real>& x) const {
  for (std::size_t i = 0; i < parts_.size(); ++i) copy_level(x, levels_[i], parts_[i]->state.x);
}

template <class Real>
double BodiesSystem<Real>::mass(std::ptrdiff_t site) const {
  auto level = levels_.end() - 1;
  while (level->first > site) --level;
  return level->body.mass(site - level->first);
}

/// Of all bodies, from their positions and velocities.
template <class Real>
void BodiesSystem<Real>::accelerate(double t) {
  for_each_part(
      [&](Part& part, const Level&) { part.system->acceleration(t, part.state.x, part.state.v, part.a); });
  if (forces_) {
    forces_->template find<Real>(positions());
    if (forces_->touches()) forces_->template add_accelerations<Real>(accelerations());
  }
  if (!loads_.empty()) {
    Field<Real> forces(size_);
    loads_.add(t, 0, size_, std::array<Real*, 3>{forces.axis(0), forces.axis(1), forces.axis(2)});
    for_each_part([&](Part& part, const Level& level) {
      for (const std::ptrdiff_t site : level.body.sites())
        part.a.set(site, part.a.at(site) + forces.at(level.first + site) / level.body.mass(site));
    });
  }
  if (contact_.has_collisions()) stop_sticking(t);
  for (const auto& part : parts_) part->system->clear_prescribed(part->a);
}

/// As BodySystem::stop_sticking().
template <class Real>
void BodiesSystem<Real>::stop_sticking(double t) {
  for_each_part([&](Part& part, const Level& level) {
    for (const std::ptrdiff_t site : level.body.sites())
      mss::stop_sticking({contact_, held_, impulses_.get()}, level.first + site, level.body.mass(site), t,
                         site, part.state.x, part.state.v, part.a);
  });
}

template <class Real>
void BodiesSystem<Real>::force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) {
  load_state(x, v);
  for_each_part([&](Part& part, const Level&) { part.system->force(t, part.state.x, part.state.v, part.a); });
  if (forces_) {
    forces_->template find<Real>(positions());
    if (forces_->touches()) forces_->template add_forces<Real>(accelerations());
  }
  for_each_part([&](Part& part, const Level& level) { copy_level(level, part.a, f); });
  if (!loads_.empty()) loads_.add(t, 0, size_, std::array<Real*, 3>{f.axis(0), f.axis(1), f.axis(2)});
}

template <class Real>
void BodiesSystem<Real>::acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  load_state(x, v);
  accelerate(t);
  for_each_part([&](Part& part, const Level& level) { copy_level(level, part.a, a); });
}

template <class Real>
void BodiesSystem<Real>::kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) {
  load_state(state.x, state.v);
  for (long step = 0; step < steps; ++step) {
    const double t = state.t + double(step) * dt;
    accelerate(t);
    for_each_part([&](Part& part, const Level&) {
      part.state.t = t;
      part.system->apply(update, part.a, dt, part.state);
    });
    kicked_for(*this, update.kick_before + update.kick_after);
  }
  for_each_part([&](Part& part, const Level& level) {
    copy_level(level, part.state.x, state.x);
    copy_level(level, part.state.v, state.v);
  });
  state.t += double(steps) * dt;
}

template <class Real>
Tangents<Real>* BodiesSystem<Real>::tangents() {
  return tangents_.get();
}

template <class Real>
void BodiesSystem<Real>::parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) {
  team_.for_each(count, task);
}

template <class Real>
double BodiesSystem<Real>::threads_working() const {
  return team_.threads_working();
}

template <class Real>
int BodiesSystem<Real>::threads() const {
  return team_.size();
}

template <class Real>
StoredEnergy BodiesSystem<Real>::stored_energy(const Field<Real>& x) const {
  load_positions(x);
  StoredEnergy sum;
  for (const auto& part : parts_) {
    const StoredEnergy energy = part->system->stored_energy(part->state.x);
    sum.elastic += energy.elastic;
    sum.volume += energy.volume;
    sum.relaxing += energy.relaxing;
  }
  return sum;
}

template <class Real>
double BodiesSystem<Real>::dissipated_by_relaxation() const {
  double sum = 0;
  for (const auto& part : parts_) sum += part->system->dissipated_by_relaxation();
  return sum;
}

template <class Real>
std::optional<std::vector<Eigen::Matrix3d>> BodiesSystem<Real>::cell_virials(const Field<Real>& x,
                                                                             const Field<Real>& v) const {
  std::vector<Eigen::Matrix3d> virials;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = *parts_[i];
    copy_level(x, levels_[i], part.state.x);
    copy_level(v, levels_[i], part.state.v);
    const auto of_body = part.system->cell_virials(part.state.x, part.state.v);
    if (!of_body) return std::nullopt;
    virials.insert(virials.end(), of_body->begin(), of_body->end());
  }
  return virials;
}

template <class Real>
double BodiesSystem<Real>::outer_potential(double t, const Field<Real>& x) const {
  load_positions(x);
  double sum = 0;
  loads_.add_potential(t, x, sum);
  for (const auto& part : parts_) sum += part->system->outer_potential(t, part->state.x);
  if (forces_) {
    forces_->template find<Real>(positions());
    sum += forces_->energy();
  }
  return sum;
}

template <class Real>
void BodiesSystem<Real>::add_penalty_forces(const State<Real>& state, std::vector<Wrench>& forces) const {
  if (!contact_.has_penalties()) return;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = *parts_[i];
    copy_level(state.x, levels_[i], part.state.x);
    copy_level(state.v, levels_[i], part.state.v);
    part.system->add_penalty_forces(part.state, forces);
  }
}

template <class Real>
std::optional<ContactReport> BodiesSystem<Real>::contact_at(const State<Real>& state) const {
  if (!forces_) return std::nullopt;
  load_positions(state.x);
  forces_->template find<Real>(positions());
  return forces_->report();
}

template <class Real>
std::vector<ContactForces::Point> BodiesSystem<Real>::touches_at(const State<Real>& state) const {
  if (!forces_) return {};
  load_positions(state.x);
  forces_->template find<Real>(positions());
  return forces_->points();
}

/// What it has come to is no longer where it is.
template <class Real>
void BodiesSystem<Real>::wake_all() {
  if (forces_) forces_->forget();
}

template <class Real>
void BodiesSystem<Real>::remember(Record& record) {
  if (impulses_) record.keep(*impulses_);
  if (forces_) record.keep(*forces_);
  for (const auto& part : parts_) record.keep(*part->system);
}

template <class Real>
bool BodiesSystem<Real>::Events::collide(const State<Real>& before, double dt, State<Real>& state) {
  const Colliding colliding{system_.contact_, system_.held_, system_.impulses_.get()};
  if (colliding.impulses) colliding.impulses->end_step(dt);
  std::atomic<bool> any{false};
  system_.for_each_part([&](Part&, const Level& level) {
    for (const std::ptrdiff_t site : level.body.sites())
      if (collide_particle(colliding, level.first + site, level.body.mass(site), before, dt, state))
        any.store(true, std::memory_order_relaxed);
  });
  return any;
}

template <class Real>
void BodiesSystem<Real>::Memory::come_to(const State<Real>& state) {
  system_.load_state(state.x, state.v);
  for (const auto& part : system_.parts_) {
    part->state.t = state.t;
    if (StepMemory<Real>* memory = part->system->memory()) memory->come_to(part->state);
  }
  if (system_.forces_) system_.forces_->template come_to<Real>(system_.positions());
}

template <class Real>
void BodiesSystem<Real>::Memory::forget() {
  for (const auto& part : system_.parts_)
    if (StepMemory<Real>* memory = part->system->memory()) memory->forget();
  if (system_.forces_) system_.forces_->forget();
}

template <class Real>
bool BodiesSystem<Real>::Memory::limits_order() const {
  return std::any_of(system_.parts_.begin(), system_.parts_.end(),
                     [](const auto& part) { return part->system->memory() != nullptr; });
}

template class BodiesSystem<float>;
template class BodiesSystem<double>;

}  // namespace mss
