#include "core/system/plane_impulses.hpp"

#include "core/base/record.hpp"

namespace mss {

PlaneImpulses::PlaneImpulses(std::size_t planes, std::ptrdiff_t sites)
    : given_(planes, Field<double>(sites)),
      force_(sites),
      held_by_(std::size_t(sites), nothing),
      held_since_(std::size_t(sites), 0) {}

Vec3 PlaneImpulses::at(std::size_t plane, std::ptrdiff_t site) const {
  const Vec3 given = given_[plane].at(site);
  return held_by_[std::size_t(site)] == plane ? Vec3(given + pending(site)) : given;
}

void PlaneImpulses::finish(std::ptrdiff_t site) {
  add(held_by_[std::size_t(site)], site, pending(site));
  held_by_[std::size_t(site)] = nothing;
}

void PlaneImpulses::hold(std::size_t plane, std::ptrdiff_t site, const Vec3& force) {
  let_go(site);
  held_by_[std::size_t(site)] = std::uint32_t(plane);
  held_since_[std::size_t(site)] = kicked_;
  force_.set(site, force);
}

void PlaneImpulses::hold_for(double seconds) {
  kicked_ += seconds;
  is_told_ = true;
}

void PlaneImpulses::end_step(double dt) {
  if (!is_told_) kicked_ += dt;
  is_told_ = false;
}

void PlaneImpulses::remember(Record& record) {
  const auto sites = std::ptrdiff_t(held_by_.size());
  for (Field<double>& given : given_) record.keep_field(given, sites);
  record.keep_field(force_, sites);
  record.keep(held_by_, held_since_, kicked_, is_told_);
}

}  // namespace mss
