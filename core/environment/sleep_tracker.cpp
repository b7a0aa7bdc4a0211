#include "core/environment/sleep_tracker.hpp"

#include <algorithm>
#include <utility>

#include "core/base/record.hpp"

namespace mss {

namespace {

/// A plane's motion is noticed by so many planes on either side before it has left where it rested.
constexpr int reach = 3;

}  // namespace

template <class Real>
SleepTracker<Real>::SleepTracker(const Lattice& lattice, const SleepRule& rule)
    : sites_(lattice.plane),
      all_sites_(lattice.size),
      near_(rule.bound / 4),
      after_(rule.after),
      asleep_(std::size_t(lattice.planes()), 0),
      resting_since_(std::size_t(lattice.planes()), 0) {}

template <class Real>
bool SleepTracker<Real>::update(State<Real>& state, const IsDriven& is_driven) {
  const double step = state.t - std::exchange(updated_, state.t);
  if (anchor_.size() == 0) {
    anchor_ = state.x;
    std::fill(resting_since_.begin(), resting_since_.end(), state.t);
    return false;
  }
  bool changed = false;
  std::vector<int> resting;
  for (int plane = 0; plane < planes(); ++plane) {
    if (asleep(plane) || !(is_driven(plane) || moves(plane, state, step))) continue;
    set_anchor(plane, state);
    changed |= wake_around(plane, state.t);
  }
  for (int plane = 0; plane < planes(); ++plane)
    if (!asleep(plane) && may_sleep(plane, state.t)) resting.push_back(plane);
  for (const int plane : resting) fall_asleep(plane, state);
  return changed || !resting.empty();
}

template <class Real>
void SleepTracker<Real>::wake_moving(const State<Real>& state) {
  const auto rests = [&](const Real* v) {
    return std::all_of(v, v + sites_, [](Real number) { return number == Real(0); });
  };
  updated_ = state.t;  // there are no updates while all are asleep
  std::vector<int> moving;
  for (int plane = 0; plane < planes(); ++plane)
    for (int axis = 0; axis < 3; ++axis)
      if (!rests(state.v.axis(axis) + sites_ * plane)) moving.push_back(plane);
  for (const int plane : moving) wake_around(plane, state.t);
}

template <class Real>
void SleepTracker<Real>::wake_all() {
  std::fill(asleep_.begin(), asleep_.end(), 0);
  sleeping_ = 0;
  anchor_ = Field<Real>();
}

/// Whether the next step leads a plane away from where it rested.
template <class Real>
bool SleepTracker<Real>::moves(int plane, const State<Real>& state, double step) const {
  using Coordinates = Eigen::Map<const Eigen::Array<Real, Eigen::Dynamic, 1>>;
  const auto of = [&](const Field<Real>& field, int axis) {
    return Coordinates(field.axis(axis) + sites_ * plane, sites_);
  };
  const auto change = [&](int axis) {
    return of(state.x, axis) + static_cast<Real>(step) * of(state.v, axis) - of(anchor_, axis);
  };
  const Real farthest = (change(0).square() + change(1).square() + change(2).square()).maxCoeff();
  return double(farthest) > near_ * near_;
}

template <class Real>
void SleepTracker<Real>::set_anchor(int plane, const State<Real>& state) {
  resting_since_[std::size_t(plane)] = state.t;
  for (int axis = 0; axis < 3; ++axis)
    std::copy_n(state.x.axis(axis) + sites_ * plane, sites_, anchor_.axis(axis) + sites_ * plane);
}

template <class Real>
bool SleepTracker<Real>::may_sleep(int plane, double t) const {
  const auto rests = [&](int p) {
    return p < 0 || p >= planes() || asleep(p) || t - resting_since_[std::size_t(p)] >= after_;
  };
  for (int near = plane - reach; near <= plane + reach; ++near)
    if (!rests(near)) return false;
  return true;
}

template <class Real>
void SleepTracker<Real>::fall_asleep(int plane, State<Real>& state) {
  asleep_[std::size_t(plane)] = 1;
  ++sleeping_;
  for (int axis = 0; axis < 3; ++axis) std::fill_n(state.v.axis(axis) + sites_ * plane, sites_, Real(0));
}

/// A plane and its neighbours. False if all of them were awake.
template <class Real>
bool SleepTracker<Real>::wake_around(int plane, double t) {
  bool any = false;
  for (int k = std::max(0, plane - reach); k <= std::min(planes() - 1, plane + reach); ++k) {
    if (!asleep(k)) continue;
    asleep_[std::size_t(k)] = 0;
    --sleeping_;
    resting_since_[std::size_t(k)] = t;
    any = true;
  }
  return any;
}

template <class Real>
void SleepTracker<Real>::remember(Record& record) {
  record.keep(asleep_, sleeping_, updated_, resting_since_);
  record.keep_field(anchor_, all_sites_);
}

template class SleepTracker<float>;
template class SleepTracker<double>;

}  // namespace mss
