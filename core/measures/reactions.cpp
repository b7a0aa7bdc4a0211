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
  return all_finite(holds) && all_finite(planes);
}

void Reactions::remember(Record& record) { record.keep(holds, planes); }

void for_each(const Reactions& reactions, const std::function<void(const std::string&, const Vec3&)>& visit) {
  for (std::size_t i = 0; i < reactions.holds.size(); ++i)
    visit(fmt::format("hold_{}", i), reactions.holds[i]);
  for (std::size_t i = 0; i < reactions.planes.size(); ++i)
    visit(fmt::format("plane_{}", i), reactions.planes[i]);
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
  given_ = impulses();
}

template <class Real>
void ReactionGauge<Real>::begin(double t) {
  begun_ = t;
  given_ = impulses();
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
std::vector<Vec3> ReactionGauge<Real>::penalties(const State<Real>& state) const {
  std::vector<Vec3> forces(std::size_t(std::count(laws_.begin(), laws_.end(), ContactLaw::penalty)),
                           Vec3::Zero());
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
  const std::vector<Vec3> given = impulses(), pushed = penalties(state);
  const double seconds = state.t - begun_;
  std::size_t impulse = 0, penalty = 0;
  for (const ContactLaw law : laws_) {
    if (law == ContactLaw::penalty) {
      reactions.planes.push_back(pushed[penalty++]);
    } else {
      const Vec3 gained = given[impulse] - given_[impulse];
      reactions.planes.push_back(seconds > 0 ? Vec3(gained / seconds) : Vec3(Vec3::Zero()));
      ++impulse;
    }
  }
  return reactions;
}

template <class Real>
void ReactionGauge<Real>::remember(Record& record) {
  record.keep(begun_, given_);
}

template class ReactionGauge<float>;
template class ReactionGauge<double>;

}  // namespace mss
