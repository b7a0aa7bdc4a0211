#include "integrators/nonlinear/bounded_system.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.hpp"

namespace mss {

namespace {

/// Shares of a body's length, of gravity's impulse and of a limit of friction that count as nothing.
constexpr double negligible_gap = 1e-14, negligible_impulse = 1e-13, negligible_share = 1e-9;

/// A particle that has changed so often in a stage sticks once it has stopped: it is on the edge of the cone,
/// and sliding to and fro it would never settle.
constexpr int most_changes = 4;

/// Of friction's limit: by how much such a particle may exceed it, twice as much after every further change.
constexpr double share_on_edge = 0.02;

/// A coefficient of friction from which on particles stick first, and slide when they must.
constexpr double rough = 1;

/// Of gravity's impulse: what is left to solve below it leaves no doubt.
constexpr double settled_share = 1e-6;

/// Of momentum: what is no less than gravity's impulse, where that is small or there is none.
constexpr double share_of_momentum = 0.01;

/// Held directions of assembled matrices are that much stiffer than the rest.
constexpr double stiffer = 1e8;

}  // namespace

BoundedSystem::BoundedSystem(System<double>& other)
    : SystemWrapper<double>(other), bounds_(*other.bounds()), tangents_(*this) {
  constexpr std::size_t most = std::numeric_limits<Planes>::digits;
  if (bounds_.size() > most)
    throw InputError(fmt::format(
        "at most {} planes and obstacles can act inside the steps of implicit methods, and there are {}; "
        "leave out those that the body cannot meet, or take an explicit method",
        most, bounds_.size()));
}

Vec3 BoundedSystem::contact_position(std::ptrdiff_t site, const Field<double>& v) const {
  return base_->at(site) + gamma_ * v.at(site);
}

/// To where a plane may leave the particle.
double BoundedSystem::gap(std::size_t plane, std::ptrdiff_t site, const Vec3& x) const {
  const std::size_t planes = bounds_.planes().size();
  if (plane < planes)
    return bounds_.planes()[plane].gap(x) - bounds_.allowed_gap(plane, start_->at(site), t_ - gamma_, gamma_);
  const Met& met = met_[plane - planes][std::size_t(site)];
  return met.plane.plane.gap(x) - met.allowed;
}

/// Particles are expected where their velocity at the stage's base and gravity take them. A search for an
/// equilibrium takes no time.
void BoundedSystem::find_obstacles(const ImplicitStage& stage) {
  if (!bounds_.has_obstacles()) return;
  const std::size_t planes = bounds_.planes().size();
  met_.resize(bounds_.size() - planes, std::vector<Met>(std::size_t(size())));
  const bool is_search = stage.force_velocity != nullptr;
  const double since = stage.start ? stage.since : gamma_, time = is_search ? 0 : since;
  for_each_particle(*this, [&](std::ptrdiff_t site) {
    const Vec3 from = start_->at(site), v = stage.v_base->at(site) + stage.gamma * bounds_.gravity();
    const Vec3 to = base_->at(site) + bounds_.free_axes(site).cwiseProduct(gamma_ * v);
    for (std::size_t o = 0; o < met_.size(); ++o) {
      Met& met = met_[o][std::size_t(site)];
      met = {bounds_.plane(planes + o, {from, to, t_, time}),
             bounds_.allowed_gap(planes + o, from, t_ - time, gamma_)};
      if (is_search) met.plane.velocity = Vec3::Zero();
    }
  });
}

/// With which what touches a particle moves, the mean of some planes [m/s].
Vec3 BoundedSystem::velocity(std::ptrdiff_t site, Planes planes) const {
  Vec3 sum = Vec3::Zero();
  if (met_.empty() || planes == 0) return sum;
  const std::vector<std::size_t> on = indices(planes);
  for (const std::size_t p : on) sum += plane(p, site).velocity;
  return sum / double(on.size());
}

void BoundedSystem::begin(const ImplicitStage& stage) {
  if (in_step_) remember_touches();
  in_step_ = true;
  base_ = stage.bound_base ? stage.bound_base : stage.x_base;
  start_ = stage.start ? stage.start : base_;
  gamma_ = stage.bound_base ? stage.bound_gamma : stage.gamma_x;
  t_ = stage.bound_base ? stage.t + stage.bound_gamma - stage.gamma : stage.t;
  find_obstacles(stage);
  double squares = 0;
  length_ = 0;
  for (const std::ptrdiff_t site : particles()) {
    const double speed =
        std::max(stage.gamma * bounds_.gravity().norm(), share_of_momentum * stage.v_base->at(site).norm());
    squares += std::pow(mass(site) * speed, 2);
    length_ = std::max(length_, base_->at(site).cwiseAbs().maxCoeff());
  }
  scale_ = std::sqrt(ranks().sum(squares));
  length_ = ranks().largest(length_);
  for (auto& [site, touch] : touches_) {  // what sticks on the edge of the cone goes on to
    touch.changes = touch.sticks && touch.changes >= most_changes ? most_changes : 0;
    if (!met_.empty()) turn(site, touch);
  }
}

/// To where an obstacle's surface is nearest now: what slid on it has come to another normal.
void BoundedSystem::turn(std::ptrdiff_t site, Touch& touch) const {
  set_directions(site, touch);
  const Vec3 along = touch.slip * touch.direction;
  if (!touch.sticks && !along.isZero(0)) touch.direction = along.normalized();
}

/// An orthonormal basis of the normals of its planes, in free directions.
void BoundedSystem::set_directions(std::ptrdiff_t site, Touch& touch) const {
  const Vec3 free = bounds_.free_axes(site);
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  for (std::size_t p = 0; p < bounds_.size(); ++p) {
    if ((touch.planes >> p & 1) == 0) continue;
    Vec3 n = free.cwiseProduct(plane(p, site).plane.normal);
    n -= normals * n;
    if (n.norm() > 1e-6) normals += n.normalized() * n.normalized().transpose();
  }
  const Eigen::Matrix3d all = free.asDiagonal();
  touch.held = touch.sticks ? all : normals;
  touch.slip = all - normals;
}

void BoundedSystem::clear_prescribed(Field<double>& field) const {
  other().clear_prescribed(field);
  for (const auto& [site, touch] : touches_) {
    const Vec3 value = field.at(site);
    field.set(site, value - touch.held * value);
  }
}

bool BoundedSystem::jump(Field<double>& v, Field<double>& change) const {
  double largest = 0;
  change.array() = 0;
  for (const auto& [site, touch] : touches_) {
    Vec3 by =
        touch.sticks ? Vec3(touch.slip * (velocity(site, touch.planes) - v.at(site))) : Vec3(Vec3::Zero());
    const Vec3 free = bounds_.free_axes(site);
    // Planes one after the other, each along what is left of its normal: exact for as many as there are.
    Eigen::Matrix3d done = Eigen::Matrix3d::Zero();
    for (std::size_t p = 0; p < bounds_.size(); ++p) {
      const bool touches = (touch.planes >> p & 1) != 0;
      if (!touches && !touch.sticks) continue;
      Vec3 n = free.cwiseProduct(plane(p, site).plane.normal);
      n -= done * n;
      if (n.norm() <= 1e-6) continue;
      const double gap = this->gap(p, site, contact_position(site, v) + gamma_ * by);
      if (!touches && gap >= 0) continue;  // friction keeps what sticks in front of others
      by -= gap / gamma_ / n.squaredNorm() * n;
      done += n.normalized() * n.normalized().transpose();
    }
    change.set(site, by);
    largest = std::max(largest, by.cwiseAbs().maxCoeff());
  }
  if (ranks().largest(largest) * gamma_ > 1e-10 * length_) return true;
  for (const auto& [site, touch] : touches_) v.set(site, v.at(site) + change.at(site));
  return false;
}

void BoundedSystem::add_friction(const Field<double>& v, Field<double>& impulse) {
  for (auto& [site, touch] : touches_) {
    if (touch.sticks || touch.limit == 0) continue;
    const Vec3 sliding = touch.slip * (v.at(site) - velocity(site, touch.planes));
    if (sliding.dot(touch.direction) > 0) touch.direction = sliding.normalized();
    impulse.set(site, impulse.at(site) - touch.limit * touch.direction);
  }
}

/// The change of friction's direction with the velocity.
Eigen::Matrix3d BoundedSystem::friction_block(std::ptrdiff_t site, const Touch& touch,
                                              const Field<double>& v) const {
  if (touch.sticks || touch.limit == 0) return Eigen::Matrix3d::Zero();
  const Vec3 sliding = touch.slip * (v.at(site) - velocity(site, touch.planes));
  if (!(sliding.dot(touch.direction) > 0)) return Eigen::Matrix3d::Zero();
  const Vec3 along = sliding.normalized();
  const double steepest = stiffer * mass(site);  // what turns on the spot must not drown the rest in rounding
  return std::min(touch.limit / sliding.norm(), steepest) * (touch.slip - along * along.transpose());
}

double BoundedSystem::follow_pressure() {
  double largest = 0;
  for (auto& [site, touch] : touches_) {
    if (!touch.sticks) largest = std::max(largest, std::abs(touch.pressure - touch.limit));
    touch.limit = touch.pressure;
  }
  return ranks().largest(largest);
}

bool BoundedSystem::slides() const {
  const bool none = std::none_of(touches_.begin(), touches_.end(), [](const auto& entry) {
    return !entry.second.sticks && entry.second.pressure > 0;
  });
  return !ranks().all(none);
}

double BoundedSystem::slowest(const Field<double>& v) const {
  double least = std::numeric_limits<double>::max();
  for (const auto& [site, touch] : touches_)
    if (!touch.sticks && touch.pressure > 0)
      least = std::min(least, (touch.slip * (v.at(site) - velocity(site, touch.planes))).norm());
  return -ranks().largest(-least);
}

double BoundedSystem::push() const {
  double squares = 0;
  for (const auto& [site, touch] : touches_) squares += touch.push * touch.push;
  return std::sqrt(ranks().sum(squares));
}

std::vector<HeldParticle> BoundedSystem::held(const Field<double>& v) const {
  std::vector<HeldParticle> all;
  for (const auto& [site, touch] : touches_)
    all.push_back({site, touch.held, friction_block(site, touch, v)});
  return all;
}

void BoundedSystem::put_in_front(Field<double>& v) {
  const std::vector<double> any(bounds_.size(), negligible_gap * length_);
  for (const std::ptrdiff_t site : particles()) close(site, v, any);
  Field<double> change(size());
  if (!jump(v, change)) return;
  for (const auto& [site, touch] : touches_) v.set(site, v.at(site) + change.at(site));
}

bool BoundedSystem::update(const Field<double>& residual, const Field<double>& v, double doubt) {
  bool changed = false;
  for (auto at = touches_.begin(); at != touches_.end();) {
    const Vec3 relative = v.at(at->first) - velocity(at->first, at->second.planes);
    changed |= judge(at->first, at->second, -residual.at(at->first), relative, doubt);
    at = at->second.planes == 0 ? touches_.erase(at) : std::next(at);
  }
  changed |= close_deepest(v);
  return !ranks().all(!changed);
}

/// Of particles behind a plane those that are up to half a cell less deep than the deepest: others may be
/// there only because these have not stopped the body yet.
bool BoundedSystem::close_deepest(const Field<double>& v) {
  std::vector<double> from;
  for (std::size_t p = 0; p < bounds_.size(); ++p) {
    double deepest = 0;
    for (const std::ptrdiff_t site : particles())
      deepest = std::max(deepest, -gap(p, site, contact_position(site, v)));
    from.push_back(std::max(negligible_gap * length_, ranks().largest(deepest) - bounds_.cell_size() / 2));
  }
  bool changed = false;
  for (const std::ptrdiff_t site : particles()) changed |= close(site, v, from);
  return changed;
}

/// On planes this rough what slides is the exception, and the friction of pressures that are not known yet
/// would throw it back.
bool BoundedSystem::sticks_at_first(std::ptrdiff_t site, Planes planes) const {
  const std::vector<std::size_t> on = indices(planes);
  return std::any_of(on.begin(), on.end(),
                     [&](std::size_t p) { return plane(p, site).plane.friction >= rough; });
}

/// Takes planes that a particle is behind, by depths `from` on [m].
bool BoundedSystem::close(std::ptrdiff_t site, const Field<double>& v, const std::vector<double>& from) {
  const Vec3 x = contact_position(site, v);
  Planes behind = 0;
  for (std::size_t p = 0; p < bounds_.size(); ++p)
    if (-gap(p, site, x) > from[p]) behind |= Planes{1} << p;
  if (behind == 0 || bounds_.free_axes(site).isZero(0)) return false;
  const auto [at, is_new] = touches_.try_emplace(site);
  Touch& touch = at->second;
  if ((touch.planes | behind) == touch.planes || (touch.sticks && !is_new)) return false;
  touch.planes |= behind;
  touch.sticks = false;
  set_directions(site, touch);
  const Vec3 sliding = touch.slip * (v.at(site) - velocity(site, touch.planes));
  touch.sticks = sliding.norm() * gamma_ < negligible_share * length_ || sticks_at_first(site, behind);
  if (!touch.sticks) touch.direction = sliding.normalized();
  if (is_new) touch.limit = 0;
  set_directions(site, touch);
  return true;
}

/// By planes that touch it, what they push with; of several sets the smallest. Returns the limit of friction.
double BoundedSystem::pressures(std::ptrdiff_t site, const Touch& touch, const Vec3& reaction,
                                std::vector<std::pair<std::size_t, double>>& by_plane) const {
  const Vec3 free = bounds_.free_axes(site), on_free = free.cwiseProduct(reaction);
  by_plane.clear();
  for (std::size_t p = 0; p < bounds_.size(); ++p)
    if ((touch.planes >> p & 1) != 0) by_plane.emplace_back(p, 0);
  const auto normal = [&](std::size_t k) -> Vec3 {
    return free.cwiseProduct(plane(by_plane[k].first, site).plane.normal);
  };
  if (by_plane.size() == 1) {
    const Vec3 n = normal(0);
    by_plane[0].second = n.isZero(0) ? 0 : n.dot(on_free) / n.squaredNorm();
  } else {
    Eigen::Matrix3Xd normals(3, by_plane.size());
    for (std::size_t k = 0; k < by_plane.size(); ++k) normals.col(Eigen::Index(k)) = normal(k);
    const Eigen::VectorXd all = normals.completeOrthogonalDecomposition().solve(on_free);
    for (std::size_t k = 0; k < by_plane.size(); ++k) by_plane[k].second = all[Eigen::Index(k)];
  }
  double limit = 0;
  for (const auto& [p, pressure] : by_plane) limit += plane(p, site).plane.friction * std::max(0.0, pressure);
  return limit;
}

double BoundedSystem::expect_pressure(const Field<double>& residual, double most, Field<double>& left) {
  double largest = 0;
  for (auto& [site, touch] : touches_) {
    if (touch.sticks) continue;
    touch.expected = pressures(site, touch, -residual.at(site), by_plane_);
    largest = std::max(largest, std::abs(touch.expected - touch.limit));
  }
  largest = ranks().largest(largest);
  if (!(largest <= most)) return largest;
  for (auto& [site, touch] : touches_) {
    if (touch.sticks) continue;
    left.set(site, left.at(site) - (touch.expected - touch.limit) * touch.direction);
    touch.limit = touch.expected;
  }
  return largest;
}

/// Lets go of a plane that pulls, or changes between sticking and sliding.
bool BoundedSystem::judge(std::ptrdiff_t site, Touch& touch, const Vec3& reaction, const Vec3& v,
                          double doubt) {
  const Vec3 on_free = bounds_.free_axes(site).cwiseProduct(reaction);
  const double limit = pressures(site, touch, reaction, by_plane_);
  const auto weakest = std::min_element(by_plane_.begin(), by_plane_.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
  const double pull = -weakest->second;
  if (pull > negligible_impulse * scale_ && (3 * pull >= doubt || doubt < 1e3 * settled_share * scale_)) {
    touch.planes &= ~(Planes{1} << weakest->first);
    touch.sticks = false;
    touch.limit = touch.pressure = 0;
    ++touch.changes;
    set_directions(site, touch);
    return true;
  }
  touch.pressure = limit;
  touch.push = 0;
  for (const auto& [plane, pressure] : by_plane_) touch.push += std::max(0.0, pressure);
  const bool stuck = touch.sticks;
  if (stuck) {
    const Vec3 tangential = touch.slip * on_free;
    const double excess = tangential.norm() - limit;
    const double allowed = touch.changes < most_changes
                               ? negligible_share
                               : std::ldexp(share_on_edge, touch.changes - most_changes);
    if (excess > limit * allowed + 0.1 * negligible_impulse * scale_ &&
        3 * excess + settled_share * scale_ >= doubt) {
      touch.sticks = false;
      touch.direction = -tangential.normalized();
    }
  } else if (limit > 0 && limit >= doubt && (touch.slip * v).dot(touch.direction) <= 0) {
    touch.sticks = true;
  }
  if (touch.sticks == stuck) return false;
  ++touch.changes;
  set_directions(site, touch);
  return true;
}

std::vector<std::size_t> BoundedSystem::indices(Planes planes) const {
  std::vector<std::size_t> all;
  for (std::size_t p = 0; p < bounds_.size(); ++p)
    if ((planes >> p & 1) != 0) all.push_back(p);
  return all;
}

/// Writes down what some planes give a particle together; of what `must_push` nothing that would pull, which
/// has not been solved.
void BoundedSystem::give(std::ptrdiff_t site, Planes planes, const Vec3& impulse, bool must_push) {
  PlaneImpulses* impulses = plane_impulses();
  if (!impulses || impulse.isZero(0)) return;
  const std::vector<std::size_t> on = indices(planes);
  std::vector<Plane> all = bounds_.planes();
  for (std::size_t p = all.size(); p < bounds_.size(); ++p) all.push_back(plane(p, site).plane);
  const std::vector<Vec3> parts = split_by_plane(all, on, bounds_.free_axes(site), impulse);
  for (const std::size_t p : on)
    if (!must_push || all[p].normal.dot(parts[p]) > 0) impulses->add(p, site, parts[p]);
}

void BoundedSystem::end_stage(const ImplicitStage& stage, const Field<double>& residual) {
  if (stage.impulse_weight == 0) return;
  for (const auto& [site, touch] : touches_)
    give(site, touch.planes, -stage.impulse_weight * residual.at(site), true);
}

void BoundedSystem::remember_touches() {
  for (const auto& [site, touch] : touches_) touched_[site] |= touch.planes;
}

void BoundedSystem::end_step(const StepTaken& step, State<double>& state, Field<double>* a) {
  remember_touches();
  in_step_ = false;
  Field<double> lost;  // accelerations before
  if (a) lost = *a;
  if (a) clear_prescribed(*a);
  for (const auto& [site, planes] : touched_) {
    const auto touch = touches_.find(site);
    const auto pushed = [planes = planes](std::size_t p) { return (planes >> p & 1) != 0; };
    Motion after{state.x.at(site), state.v.at(site)};
    if (touch != touches_.end() && touch->second.sticks) {
      const Vec3 sliding = touch->second.slip * (after.v - velocity(site, planes));
      after.v -= sliding;
      give(site, planes, -mass(site) * sliding);
    }
    const Motion before{step.x->at(site), step.v->at(site)};
    const auto give_one = [&, at = site](std::size_t p, const Vec3& dv) {
      if (PlaneImpulses* impulses = plane_impulses()) impulses->add(p, at, mass(at) * dv);
    };
    const auto met = [this, at = site](std::size_t p) { return plane(p, at); };
    if (bounds_.rebound(site, step.free, before, pushed, met, after, give_one) && a)
      a->set(site, bounds_.free_axes(site).cwiseProduct(bounds_.gravity()));
    if (a) give(site, planes, step.lag * mass(site) * (a->at(site) - lost.at(site)));
    state.x.set(site, after.x);
    state.v.set(site, after.v);
  }
  touched_.clear();
}

void remember_bounded(System<double>& system, Record& record, std::shared_ptr<BoundedSystem>& bounded) {
  bool is_there = bounded != nullptr;
  record.keep(is_there);
  if (is_there && !bounded) bounded = std::make_shared<BoundedSystem>(system);
  if (is_there) record.keep(*bounded);
}

namespace {

/// Adds a block to the rows and columns of a particle's unknowns.
void add_block(const std::vector<FreeDof>& unknowns, std::ptrdiff_t site, const Eigen::Matrix3d& block,
               SparseMatrix& matrix) {
  auto first = std::lower_bound(unknowns.begin(), unknowns.end(), site,
                                [](const FreeDof& u, std::ptrdiff_t s) { return u.site < s; });
  for (auto row = first; row != unknowns.end() && row->site == site; ++row)
    for (auto column = first; column != unknowns.end() && column->site == site; ++column)
      matrix.coeffRef(int(row - unknowns.begin()), int(column - unknowns.begin())) +=
          block(row->axis, column->axis);
}

/// The largest number on the diagonal in a particle's rows.
double largest_entry(const std::vector<FreeDof>& unknowns, std::ptrdiff_t site, SparseMatrix& matrix) {
  auto row = std::lower_bound(unknowns.begin(), unknowns.end(), site,
                              [](const FreeDof& u, std::ptrdiff_t s) { return u.site < s; });
  double largest = 0;
  for (; row != unknowns.end() && row->site == site; ++row) {
    const auto at = int(row - unknowns.begin());
    largest = std::max(largest, matrix.coeff(at, at));
  }
  return largest;
}

}  // namespace

void BoundedSystem::BoundedTangents::values(double t, const Field<double>& x, const Field<double>& v,
                                            const TangentCoefficients& sum, SparseMatrix& matrix) {
  other().values(t, x, v, sum, matrix);
  for (const auto& [site, touch] : system_.touches_) {
    const double stiff = stiffer * largest_entry(unknowns(), site, matrix);
    add_block(unknowns(), site, system_.friction_block(site, touch, v) + stiff * touch.held, matrix);
  }
}

void BoundedSystem::BoundedTangents::product(double t, const Field<double>& x, const Field<double>& v,
                                             const TangentCoefficients& sum, const Field<double>& p,
                                             Field<double>& out) {
  other().product(t, x, v, sum, p, out);
  for (const auto& [site, touch] : system_.touches_)
    out.set(site, out.at(site) + system_.friction_block(site, touch, v) * p.at(site));
}

void BoundedSystem::BoundedTangents::diagonal(double t, const Field<double>& x, const Field<double>& v,
                                              const TangentCoefficients& sum,
                                              std::vector<Eigen::Matrix3d>& blocks) {
  other().diagonal(t, x, v, sum, blocks);
  const std::vector<std::ptrdiff_t>& sites = system_.particles();
  for (const auto& [site, touch] : system_.touches_) {
    const auto id = std::size_t(std::lower_bound(sites.begin(), sites.end(), site) - sites.begin());
    blocks[id] += system_.friction_block(site, touch, v);
    blocks[id] += stiffer * blocks[id].diagonal().maxCoeff() * touch.held;
  }
}

}  // namespace mss
