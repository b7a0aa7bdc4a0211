#include "core/measures/reactions.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/record.hpp"
#include "core/system/plane_impulses.hpp"

namespace mss {

namespace {

/// Of a hold, on one coordinate.
struct HoldForce {
  std::size_t hold;
  int axis;
  double force;  ///< [N]
};

}  // namespace

bool Reactions::is_finite() const {
  const auto all_finite = [](const std::vector<Vec3>& forces) {
    return std::all_of(forces.begin(), forces.end(), [](const Vec3& force) { return force.allFinite(); });
  };
  return all_finite(holds) && all_finite(planes) && all_finite(obstacles) && all_finite(torques);
}

void Reactions::remember(Record& record) { record.keep(holds, planes, obstacles, torques); }

void for_each(const Reactions& reactions, const std::function<void(const std::string&, const Vec3&)>& visit) {
  for (std::size_t i = 0; i < reactions.holds.size(); ++i)
    visit(fmt::format("hold_{}", i), reactions.holds[i]);
  for (std::size_t i = 0; i < reactions.planes.size(); ++i)
    visit(fmt::format("plane_{}", i), reactions.planes[i]);
  for (std::size_t i = 0; i < reactions.obstacles.size(); ++i) {
    visit(fmt::format("obstacle_{}", i), reactions.obstacles[i]);
    visit(fmt::format("obstacle_{}_torque", i), reactions.torques[i]);
  }
}

void for_each_component(const Reactions& reactions,
                        const std::function<void(const std::string&, double)>& visit) {
  for_each(reactions, [&](const std::string& name, const Vec3& force) {
    for (int axis = 0; axis < 3; ++axis) visit(fmt::format("{}_{}", name, "xyz"[axis]), force[axis]);
  });
}

template <class Real>
ReactionGauge<Real>::ReactionGauge(SolidSystem<Real>& system, const Environment& environment)
    : system_(system), holds_(environment.holds.size()), held_(system.levels(), environment.holds) {
  for (const Plane& plane : environment.planes) laws_.push_back(plane.contact);
  for (const Obstacle& obstacle : environment.obstacles) {
    laws_.push_back(obstacle.contact);
    obstacles_.emplace_back(obstacle);
  }
  keep_given();
}

template <class Real>
void ReactionGauge<Real>::keep_given() {
  given_ = impulses();
  given_at_.clear();
  const PlaneImpulses* impulses = system_.plane_impulses();
  if (!impulses || obstacles_.empty()) return;
  for (std::size_t p = 0; p < given_.size(); ++p) {
    Field<double>& given = given_at_.emplace_back(system_.size());
    for (const std::ptrdiff_t site : system_.particles()) given.set(site, impulses->at(p, site));
  }
}

template <class Real>
void ReactionGauge<Real>::begin(double t) {
  begun_ = t;
  keep_given();
}

/// By plane that gives impulses, all that it has given [N s].
template <class Real>
std::vector<Vec3> ReactionGauge<Real>::impulses() const {
  const PlaneImpulses* impulses = system_.plane_impulses();
  if (!impulses) return {};
  std::vector<Vec3> given(impulses->planes(), Vec3::Zero());
  for (std::size_t p = 0; p < given.size(); ++p)
    system_.ranks().add_in_order(given[p], [&] {
      for (const std::ptrdiff_t site : system_.particles()) given[p] += impulses->at(p, site);
    });
  return given;
}

template <class Real>
std::vector<Wrench> ReactionGauge<Real>::penalties(const State<Real>& state) const {
  std::vector<Wrench> forces(std::size_t(std::count(laws_.begin(), laws_.end(), ContactLaw::penalty)),
                             Wrench::Zero());
  system_.add_penalty_forces(state, forces);
  return forces;
}

template <class Real>
void ReactionGauge<Real>::add_holds(System<Real>& driven, const State<Real>& state,
                                    std::vector<Vec3>& forces) {
  if (force_.size() == 0) force_ = Field<Real>(system_.size());
  driven.force(state.t, state.x, state.v, force_);
  std::vector<HoldForce> parts;
  held_.for_each(state.t, [&](std::ptrdiff_t site, int axis, std::size_t hold, double acceleration) {
    if (const double mass = system_.mass(site); mass > 0)  // others follow particles of larger cells
      parts.push_back({hold, axis, mass * acceleration - double(force_.axis(axis)[site])});
  });
  for (std::size_t h = 0; h < holds_; ++h)
    system_.ranks().add_in_order(forces[h], [&] {
      for (const auto& [hold, axis, force] : parts)
        if (hold == h) forces[h][axis] += force;
    });
}

template <class Real>
Reactions ReactionGauge<Real>::read(System<Real>& driven, const State<Real>& state) {
  Reactions reactions;
  reactions.holds.assign(holds_, Vec3::Zero());
  if (holds_ > 0) add_holds(driven, state, reactions.holds);
  const std::vector<Vec3> given = impulses();
  const std::vector<Wrench> pushed = penalties(state);
  const double seconds = state.t - begun_;
  const std::size_t planes = laws_.size() - obstacles_.size();
  std::size_t impulse = 0, penalty = 0;
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const bool presses = laws_[i] == ContactLaw::penalty;
    Vec3 force = Vec3::Zero();
    if (presses)
      force = pushed[penalty].head<3>();
    else if (seconds > 0)
      force = (given[impulse] - given_[impulse]) / seconds;
    if (i < planes) {
      reactions.planes.push_back(force);
    } else {
      const Vec3 centre = obstacles_[i - planes].centre(state.t);
      reactions.obstacles.push_back(force);
      reactions.torques.push_back(presses ? Vec3(pushed[penalty].tail<3>() - centre.cross(force))
                                          : mean_torque(impulse, centre, state));
    }
    ++(presses ? penalty : impulse);
  }
  return reactions;
}

template <class Real>
Vec3 ReactionGauge<Real>::mean_torque(std::size_t impulse, const Vec3& about,
                                      const State<Real>& state) const {
  Vec3 torque = Vec3::Zero();
  const double seconds = state.t - begun_;
  if (!(seconds > 0)) return torque;
  const PlaneImpulses& impulses = *system_.plane_impulses();
  system_.ranks().add_in_order(torque, [&] {
    for (const std::ptrdiff_t site : system_.particles()) {
      const Vec3 gained = impulses.at(impulse, site) - given_at_[impulse].at(site);
      torque += (state.x.at(site) - about).cross(gained) / seconds;
    }
  });
  return torque;
}

template <class Real>
void ReactionGauge<Real>::remember(Record& record) {
  record.keep(begun_, given_);
  for (Field<double>& given : given_at_) record.keep_field(given, system_.size());
}

template class ReactionGauge<float>;
template class ReactionGauge<double>;

}  // namespace mss
