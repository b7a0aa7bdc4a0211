#include "core/body_system.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace mss {

template <class Real>
BodySystem<Real>::BodySystem(const Body& body, const Environment& environment, int threads)
    : body_(body),
      environment_(environment),
      held_(body, environment.holds),
      loads_(body, environment.loads),
      team_(threads) {
  for (const Plane& plane : environment.planes)
    if (plane.contact != ContactLaw::penalty) colliding_.push_back(plane);
}

template <class Real>
State<Real> BodySystem<Real>::undeformed_state() const {
  State<Real> state{0, Field<Real>(size()), Field<Real>(size())};
  for (std::ptrdiff_t site = 0; site < size(); ++site) state.x.set(site, body_.rest_position(site));
  return state;
}

template <class Real>
State<Real> BodySystem<Real>::rest_state() const {
  State<Real> state = undeformed_state();
  constrain(0, state.x, state.v);
  return state;
}

template <class Real>
void BodySystem<Real>::constrain(double t, Field<Real>& x, Field<Real>& v) const {
  held_.apply(t, 0, body_.lattice().sites, x, v);
}

template <class Real>
BlockMatrix& BodySystem<Real>::blocks() {
  if (!blocks_) blocks_ = std::make_unique<BlockMatrix>(body_, held_);
  return *blocks_;
}

template <class Real>
void BodySystem<Real>::add_gravity(Field<Real>& f) const {
  if (environment_.gravity.isZero(0)) return;
  for (const std::ptrdiff_t site : body_.sites())
    for (int a = 0; a < 3; ++a)
      f.axis(a)[site] += static_cast<Real>(body_.mass(site) * environment_.gravity[a]);
}

template <class Real>
void BodySystem<Real>::acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  System<Real>::acceleration(t, x, v, a);
  stop_sticking(x, v, a);
  clear_prescribed(a);
}

template <class Real>
const std::vector<Penalty>& BodySystem<Real>::penalties() const {
  if (penalties_.empty())
    for (const Plane& plane : environment_.planes)
      if (plane.contact == ContactLaw::penalty)
        penalties_.emplace_back(plane, body_bound(), environment_.gravity.norm(), body_.config().cell_size);
  return penalties_;
}

/// Stiffness and damping of a plane are proportional to mass: whatever the mode, they add to it as they are.
template <class Real>
SpectralBound BodySystem<Real>::spectral_bound() const {
  SpectralBound sum = body_bound();
  for (const Penalty& penalty : penalties()) {
    sum.omega = std::hypot(sum.omega, penalty.bound().omega);
    sum.damping += penalty.bound().damping;
  }
  return sum;
}

template <class Real>
double BodySystem<Real>::outer_potential(const Field<Real>& x) const {
  double sum = loads_.potential(x);
  for (const std::ptrdiff_t site : body_.sites()) {
    const Vec3 at = x.at(site);
    double over_mass = -environment_.gravity.dot(at);
    for (const Penalty& penalty : penalties()) over_mass += penalty.potential(at);
    sum += body_.mass(site) * over_mass;
  }
  return sum;
}

/// Calls task(site) for every particle, on all threads.
template <class Real>
template <class Task>
void BodySystem<Real>::for_each_particle(Task&& task) {
  constexpr std::ptrdiff_t portion = 256;
  const auto count = std::ptrdiff_t(body_.particle_count());
  team_.for_each((count + portion - 1) / portion, [&](std::ptrdiff_t i) {
    for (std::ptrdiff_t p = i * portion; p < std::min(count, (i + 1) * portion); ++p)
      task(body_.sites()[std::size_t(p)]);
  });
}

/// The same for those that are awake.
template <class Real>
template <class Task>
void BodySystem<Real>::for_each_particle_awake(Task&& task) {
  const std::ptrdiff_t plane = body_.lattice().plane;
  for_each_particle([&](std::ptrdiff_t site) {
    if (!sleepers_ || !sleepers_->asleep(int(site / plane))) task(site);
  });
}

template <class Real>
void BodySystem<Real>::let_sleep(const SleepRule& rule) {
  if (rule.bound > 0) sleepers_ = std::make_unique<Sleepers<Real>>(body_.lattice(), rule);
}

template <class Real>
bool BodySystem<Real>::settle(State<Real>& state) {
  const std::ptrdiff_t plane = body_.lattice().plane;
  return sleepers_ &&
         sleepers_->look(state, [&](int k) { return held_.move(state.t, plane * k, plane * (k + 1)); });
}

template <class Real>
void BodySystem<Real>::wake_moving(const State<Real>& state) {
  if (sleepers_) sleepers_->wake_moving(state);
}

template <class Real>
void BodySystem<Real>::wake_all() {
  if (sleepers_) sleepers_->wake_all();
}

template <class Real>
bool BodySystem<Real>::collide(const State<Real>& before, double dt, State<Real>& state) {
  std::atomic<bool> any{false};
  for_each_particle_awake([&](std::ptrdiff_t site) {
    if (collide_particle(site, before, dt, state)) any.store(true, std::memory_order_relaxed);
  });
  return any;
}

/// In a wedge one plane may push a particle into another, so several are asked until none has an answer. From
/// the second round on those are left alone that the particle neither is behind nor moves towards, but for
/// rounding: it is where they have just put it.
template <class Real>
bool BodySystem<Real>::collide_particle(std::ptrdiff_t site, const State<Real>& before, double dt,
                                        State<Real>& state) const {
  constexpr int most_rounds = 8;
  const Vec3 x = state.x.at(site);
  if (std::all_of(colliding_.begin(), colliding_.end(), [&](const Plane& plane) { return plane.gap(x) > 0; }))
    return false;  // no law acts in front of its plane
  const Motion start{before.x.at(site), before.v.at(site)};
  Motion end{x, state.v.at(site)};
  const auto ask = [&](const Plane& plane) {
    return plane.contact == ContactLaw::thesis ? collide_thesis(plane, start, end)
                                               : collide_impulse(plane, start, dt, end);
  };
  const double close = 1e-9 * body_.config().cell_size;
  const auto is_done = [&](const Plane& plane) {
    return plane.gap(end.x) > -close && plane.normal.dot(end.v) * dt > -close;
  };
  bool any = false;
  for (int round = 0; round < most_rounds; ++round) {
    bool touched = false;
    for (const Plane& plane : colliding_)
      if (round == 0 || !is_done(plane)) touched |= ask(plane);
    any |= touched;
    if (!touched || colliding_.size() == 1) break;
  }
  for (int axis = 0; any && axis < 3; ++axis) {
    if (held_.holds(site, axis)) continue;
    state.x.axis(axis)[site] = static_cast<Real>(end.x[axis]);
    state.v.axis(axis)[site] = static_cast<Real>(end.v[axis]);
  }
  return any;
}

template <class Real>
std::vector<double> BodySystem<Real>::kinks(const Field<Real>& x) const {
  std::vector<double> smallest(penalties().size(), std::numeric_limits<double>::infinity());
  for (const std::ptrdiff_t site : body_.sites())
    for (std::size_t p = 0; p < penalties_.size(); ++p)
      smallest[p] = std::min(smallest[p], penalties_[p].gap(x.at(site)));
  return smallest;
}

template <class Real>
Vec3 BodySystem<Real>::penalty_at(std::ptrdiff_t site, const Field<Real>& x, const Field<Real>& v) const {
  Vec3 sum = Vec3::Zero();
  for (const Penalty& penalty : penalties_)
    if (const Motion motion{x.at(site), v.at(site)}; penalty.gap(motion.x) < 0)
      sum += penalty.acceleration(motion);
  return sum;
}

template <class Real>
Eigen::Matrix3d BodySystem<Real>::penalty_tangent_at(std::ptrdiff_t site, const Field<Real>& x,
                                                     const Field<Real>& v, const TangentSum& sum) const {
  Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
  for (const Penalty& penalty : penalties_)
    if (const Motion motion{x.at(site), v.at(site)}; penalty.gap(motion.x) < 0)
      block += body_.mass(site) * penalty.tangent(motion, sum);
  return block;
}

template <class Real>
void BodySystem<Real>::add_penalty_force(const Field<Real>& x, const Field<Real>& v, Field<Real>& f) {
  if (!has_penalties()) return;
  for_each_particle(
      [&](std::ptrdiff_t site) { f.set(site, f.at(site) + body_.mass(site) * penalty_at(site, x, v)); });
}

template <class Real>
void BodySystem<Real>::add_penalty_acceleration(const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  if (!has_penalties()) return;
  for_each_particle_awake([&](std::ptrdiff_t site) { a.set(site, a.at(site) + penalty_at(site, x, v)); });
}

template <class Real>
void BodySystem<Real>::stop_sticking(const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  if (!collides()) return;
  const double close = 1e-6 * body_.config().cell_size;
  for_each_particle_awake([&](std::ptrdiff_t site) {
    for (const Plane& plane : colliding_)
      if (plane.contact == ContactLaw::impulse && sticks(plane, {x.at(site), v.at(site)}, a.at(site), close))
        a.set(site, Vec3::Zero());
  });
}

template <class Real>
void BodySystem<Real>::add_penalty_product(const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                                           const Field<Real>& p, Field<Real>& out) {
  if (!has_penalties()) return;
  for_each_particle([&](std::ptrdiff_t site) {
    out.set(site, out.at(site) + penalty_tangent_at(site, x, v, sum) * p.at(site));
  });
}

template <class Real>
void BodySystem<Real>::tangent(double, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                               SparseMatrix& matrix) {
  BlockMatrix& m = blocks();
  m.begin(sum.mass);
  add_tangent(x, v, sum, m);
  if (has_penalties())
    for (const std::ptrdiff_t site : particles()) m.add_diagonal(site, penalty_tangent_at(site, x, v, sum));
  m.write(matrix);
}

template <class Real>
void BodySystem<Real>::tangent_diagonal(double, const Field<Real>& x, const Field<Real>& v,
                                        const TangentSum& sum, std::vector<Eigen::Matrix3d>& diagonal) {
  const BlockMatrix& m = blocks();
  m.begin_diagonal(sum.mass, diagonal);
  add_tangent_diagonal(x, v, sum, m, diagonal);
  if (has_penalties())
    for (const std::ptrdiff_t site : particles())
      diagonal[m.particle(site)] += penalty_tangent_at(site, x, v, sum);
}

template class BodySystem<float>;
template class BodySystem<double>;

}  // namespace mss
