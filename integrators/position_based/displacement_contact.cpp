#include "integrators/position_based/displacement_contact.hpp"

#include <algorithm>

namespace mss {

namespace {

template <class Stream>
Vec3 at(const Stream& field, std::ptrdiff_t i) {
  return {double(field.axis[0][i]), double(field.axis[1][i]), double(field.axis[2][i])};
}

template <class Real>
void set(const Streams<Real>& field, std::ptrdiff_t i, const Vec3& value) {
  for (int axis = 0; axis < 3; ++axis) field.axis[axis][i] = static_cast<Real>(value[axis]);
}

}  // namespace

template <class Real>
DisplacementContact<Real>::DisplacementContact(const PlaneBounds& bounds, const Body& body,
                                               std::ptrdiff_t size, const std::vector<std::ptrdiff_t>& index,
                                               PlaneImpulses* impulses)
    : bounds_(bounds),
      body_(body),
      index_(index),
      impulses_(impulses),
      near_(std::size_t(body.lattice().planes()) + 1),
      near_at_(std::size_t(size), nullptr) {
  for (const std::ptrdiff_t site : body.sites())
    inverse_masses_.push_back(bounds.free_axes(site) / body.mass(site));
}

template <class Real>
bool DisplacementContact<Real>::is_pushed(const Near& near) {
  return std::any_of(near.normal.begin(), near.normal.end(), [](double normal) { return normal > 0; });
}

template <class Real>
void DisplacementContact<Real>::begin_step(double t, double dt, const ConstStreams<Real>& x,
                                           const ConstStreams<Real>& v, const ConstStreams<Real>& u) {
  const double close = body_.config().cell_size;
  const std::vector<Plane>& planes = bounds_.planes();
  t_ = t;
  dt_ = dt;
  pushed_before_.clear();
  for (auto& of_plane : near_) {
    for (const Near& near : of_plane) {
      if (is_pushed(near)) pushed_before_.push_back(near.index);
      near_at_[std::size_t(near.index)] = nullptr;
    }
    of_plane.clear();
  }
  for (std::size_t p = 0; p < index_.size(); ++p) {
    const Vec3 before = at(x, index_[p]), after = before + at(u, index_[p]);
    bool is_near = std::any_of(planes.begin(), planes.end(), [&](const Plane& plane) {
      return std::min(plane.gap(before), plane.gap(after)) < close;
    });
    std::vector<MovingPlane> met;
    for (std::size_t o = planes.size(); o < bounds_.size(); ++o) {
      met.push_back(bounds_.plane(o, {before, after, t, dt}));
      is_near |=
          std::min(met.back().plane.gap(before + met.back().moved), met.back().plane.gap(after)) < close;
    }
    if (!is_near || inverse_masses_[p].isZero(0)) continue;
    Near near{.particle = p,
              .index = index_[p],
              .inverse_mass = inverse_masses_[p],
              .met = std::move(met),
              .before = {before, at(v, index_[p])}};
    near.normal.assign(bounds_.size(), 0);
    near.tangential.assign(bounds_.size(), Vec3::Zero());
    for (std::size_t plane = 0; plane < bounds_.size(); ++plane)
      near.gap.push_back(bounds_.allowed_gap(plane, before, t - dt, dt));
    near_[std::size_t(body_.sites()[p] / body_.lattice().plane)].push_back(std::move(near));
  }
  for (auto& of_plane : near_)
    for (Near& near : of_plane) near_at_[std::size_t(near.index)] = &near;
  for (const std::ptrdiff_t index : pushed_before_)
    if (near_at_[std::size_t(index)]) near_at_[std::size_t(index)]->was_pushed = true;
}

template <class Real>
bool DisplacementContact<Real>::pushes() const {
  return std::any_of(near_.begin(), near_.end(), [](const std::vector<Near>& of_plane) {
    return std::any_of(of_plane.begin(), of_plane.end(), is_pushed);
  });
}

template <class Real>
std::optional<Plane> DisplacementContact<Real>::impact(double dt) const {
  const double slow = 2 * bounds_.gravity().norm() * dt;
  for (std::size_t p = 0; p < bounds_.size(); ++p)
    for (const std::vector<Near>& of_plane : near_)
      for (const Near& near : of_plane) {
        if (near.was_pushed) continue;
        const auto& [plane, velocity, moved] = this->plane(near, p);
        if (plane.normal.dot(near.before.v - velocity) < -slow &&
            plane.gap(near.before.x + dt * near.before.v) < 0)
          return plane;
      }
  return std::nullopt;
}

template <class Real>
void DisplacementContact<Real>::project(int first, const ConstStreams<Real>& x, const Streams<Real>& u) {
  for (std::size_t z = std::size_t(first); z < std::min(near_.size(), std::size_t(first) + 2); ++z)
    for (Near& near : near_[z]) project(near, x, u);
}

template <class Real>
void DisplacementContact<Real>::project(const ConstStreams<Real>& x, const Streams<Real>& u) {
  for (auto& of_plane : near_)
    for (Near& near : of_plane) project(near, x, u);
}

template <class Real>
void DisplacementContact<Real>::project(Near& near, const ConstStreams<Real>& x,
                                        const Streams<Real>& u) const {
  const Vec3 before = at(x, near.index), start = at(u, near.index);
  Vec3 moved = start;
  for (std::size_t plane = 0; plane < near.normal.size(); ++plane) project(near, plane, before, moved);
  if (moved != start) set(u, near.index, moved);
}

template <class Real>
void DisplacementContact<Real>::project(Near& near, std::size_t p, const Vec3& x, Vec3& u) const {
  const MovingPlane met = this->plane(near, p);
  const Plane& plane = met.plane;
  const Vec3& w = near.inverse_mass;
  const double along = plane.normal.dot(w.cwiseProduct(plane.normal)), gap = plane.gap(x + u) - near.gap[p];
  double& normal = near.normal[p];
  if (along == 0 || (gap >= 0 && normal == 0)) return;
  const double pressed = std::max(0.0, normal - gap / along);
  u += (pressed - normal) * w.cwiseProduct(plane.normal);
  normal = pressed;
  const auto tangential = [&](const Vec3& vector) {
    return Vec3(vector - plane.normal.dot(vector) * plane.normal);
  };
  Vec3 held = near.tangential[p] - tangential(u - met.moved) / w.maxCoeff();
  const double limit = plane.friction * pressed, size = held.norm();
  if (size > limit) held *= size > 0 ? limit / size : 0;
  u += w.cwiseProduct(held - near.tangential[p]);
  near.tangential[p] = held;
}

template <class Real>
template <class Moved>
void DisplacementContact<Real>::move_in_front(const ConstStreams<Real>& x, const Streams<Real>& u,
                                              Moved&& moved_by) {
  constexpr int most_rounds = 8;  // in a wedge one plane may push a particle behind another
  for (std::size_t p = 0; p < index_.size(); ++p) {
    const Vec3 before = at(x, index_[p]), start = at(u, index_[p]);
    Vec3 moved = start;
    for (int round = 0; round < most_rounds; ++round)
      for (std::size_t plane = 0; plane < bounds_.size(); ++plane) {
        const Plane met = bounds_.plane(plane, {before, before + moved, t_, dt_}).plane;
        const Vec3 free = (inverse_masses_[p].array() > 0).select(met.normal, Vec3::Zero());
        const double gap = met.gap(before + moved) - bounds_.allowed_gap(plane, before, t_ - dt_, dt_);
        if (!(gap < 0) || free.isZero(0)) continue;
        const Vec3 by = -gap / free.squaredNorm() * free;
        moved += by;
        moved_by(p, plane, by);
      }
    if (moved != start) set(u, index_[p], moved);
  }
}

template <class Real>
void DisplacementContact<Real>::put_in_front(const ConstStreams<Real>& x, const Streams<Real>& u) {
  move_in_front(x, u, [](std::size_t, std::size_t, const Vec3&) {});
}

template <class Real>
void DisplacementContact<Real>::end_passes(double dt, const ConstStreams<Real>& x, const Streams<Real>& u) {
  const std::vector<std::ptrdiff_t>& sites = body_.sites();
  for (const auto& of_plane : near_)
    for (const Near& near : of_plane)
      for (std::size_t p = 0; impulses_ && p < near.normal.size(); ++p) {
        if (near.normal[p] == 0 && near.tangential[p].isZero(0)) continue;
        const Vec3 given = near.normal[p] * plane(near, p).plane.normal + near.tangential[p];
        impulses_->add(p, sites[near.particle],
                       bounds_.free_axes(sites[near.particle]).cwiseProduct(given) / dt);
      }
  move_in_front(x, u, [&](std::size_t particle, std::size_t plane, const Vec3& by) {
    const std::ptrdiff_t site = sites[particle];
    if (impulses_) impulses_->add(plane, site, body_.mass(site) / dt * by);
  });
}

template <class Real>
void DisplacementContact<Real>::rebound(const FreeStep& step, State<Real>& state) const {
  for (const auto& of_plane : near_)
    for (const Near& near : of_plane) {
      const auto pushed = [&](std::size_t p) { return near.normal[p] > 0; };
      const std::ptrdiff_t site = body_.sites()[near.particle];
      Motion after{state.x.at(site), state.v.at(site)};
      const auto met = [&](std::size_t p) { return plane(near, p); };
      bounds_.rebound(site, step, near.before, pushed, met, after, [&](std::size_t p, const Vec3& dv) {
        if (impulses_) impulses_->add(p, site, body_.mass(site) * dv);
      });
      state.x.set(site, after.x);
      state.v.set(site, after.v);
    }
}

template <class Real>
void DisplacementContact<Real>::remember(Record& record) {
  std::vector<std::ptrdiff_t> pushed;
  for (const std::vector<Near>& of_plane : near_)
    for (const Near& near : of_plane)
      if (is_pushed(near)) pushed.push_back(near.index);
  record.keep(pushed);
  if (!record.reads()) return;
  for (std::vector<Near>& of_plane : near_) of_plane.clear();
  std::fill(near_at_.begin(), near_at_.end(), nullptr);
  for (const std::ptrdiff_t index : pushed) {  // until the next step begins
    Near& near = near_.front().emplace_back();
    near.index = index;
    near.normal = {1};
  }
}

template class DisplacementContact<float>;
template class DisplacementContact<double>;

}  // namespace mss
