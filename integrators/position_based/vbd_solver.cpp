#include "integrators/position_based/vbd_solver.hpp"

#include <algorithm>

#include "integrators/position_based/block_in_cone.hpp"

namespace mss {

namespace {

/// A lane is a particle: the kind of its mass, from 1, and those of the elements of the sites of whose
/// corners 0 to 7 it is.
constexpr int lane_size = 9;

template <class Real>
ColouredBlocks blocks_of(const ColouredParticles<Real>& particles, int lanes) {
  const Body& body = particles.body();
  const Lattice& sites = body.lattice();
  const auto describe = [&](int colour, const std::array<int, 3>& at, std::ptrdiff_t within,
                            std::uint32_t* numbers) {
    const std::ptrdiff_t site = sites.site(at[0], at[1], at[2]);
    if (body.particle(site) < 0) return;
    numbers[0] = 1 + particles.mass_kind(within + particles.lattice().corner(colour, 0));
    for (int c = 0; c < 8; ++c) {
      const bool inside = at[0] >= corner_bit(c, 0) && at[1] >= corner_bit(c, 1) && at[2] >= corner_bit(c, 2);
      numbers[1 + c] = inside ? 1 + body.kind(site - sites.corner(c)) : 0;
    }
  };
  return {particles.lattice(), lanes, lane_size, describe};
}

}  // namespace

template <class Real>
VbdSolver<Real>::VbdSolver(const SpringSystem<Real>& springs, System<Real>& system, double dt,
                           double chebyshev_radius)
    : system_(system),
      springs_(springs),
      particles_(springs, system),
      kernel_(fastest_copy<VbdKernel<Real>>()),
      damped_(springs.body().config().is_damped()),
      dt_(dt),
      squared_radius_(chebyshev_radius * chebyshev_radius),
      blocks_(blocks_of(particles_, kernel_.lanes)),
      target_(particles_.lattice().size()),
      drift_(particles_.lattice().size()),
      gravity_(springs.environment().gravity) {
  if (system.bounds()) {
    near_ = std::make_unique<DisplacementContact<Real>>(*system.bounds(), springs.body(),
                                                        particles_.lattice().size(), particles_.index(),
                                                        system.plane_impulses());
    contact_ = std::make_unique<VertexContact<Real>>(*near_, particles_, dt);
  }
  fill_dictionary();
  if (chebyshev_radius > 0) last_ = one_before_ = target_;
  for (int colour = 0; colour < ColouredLattice::colours; ++colour)
    parts_[std::size_t(colour)] = part_of(colour);
}

template <class Real>
void VbdSolver<Real>::fill_dictionary() {
  const std::ptrdiff_t size = std::ptrdiff_t(descent_coefficients) * kernel_.lanes;
  dictionary_ = AlignedArray<Real>(size * std::ptrdiff_t(blocks_.size()));
  planes_.assign(blocks_.size(), 0);
  for (std::size_t entry = 1; entry < blocks_.size(); ++entry)
    for (int lane = 0; lane < kernel_.lanes; ++lane) {
      Real* coefficients = dictionary_.data() + size * std::ptrdiff_t(entry) + lane;
      fill_lane(blocks_.lane(entry, lane), coefficients);
      planes_[entry] = std::uint8_t(planes_[entry] | planes_of(coefficients));
    }
}

template <class Real>
void VbdSolver<Real>::fill_lane(const std::uint32_t* lane, Real* coefficients) const {
  Real& inertia = coefficients[std::ptrdiff_t(kernel_.lanes) * (2 * sites_around + 8)];
  inertia = 1;  // keeps the matrix regular where there is no particle
  if (lane[0] == 0) return;
  const Body& body = particles_.body();
  const double scale2 = double(kernel_.rsqrt_scale) * double(kernel_.rsqrt_scale);
  if (const double inverse = particles_.masses()[lane[0] - 1]; inverse > 0)
    inertia = static_cast<Real>(1 / (inverse * dt_ * dt_));
  for (int own = 0; own < 8; ++own) {
    if (lane[1 + own] == 0) continue;
    const SiteElements e = body.kinds().elements(lane[1 + own] - 1);
    for (std::size_t s = 0; s < spring_slots.size(); ++s) {
      const SpringSlot& slot = spring_slots[s];
      if (slot.a != own && slot.b != own) continue;
      const int other = corner_places.of[own][slot.a == own ? slot.b : slot.a];
      coefficients[std::ptrdiff_t(kernel_.lanes) * other] += static_cast<Real>(e.stiffness[s]);
      coefficients[std::ptrdiff_t(kernel_.lanes) * (sites_around + other)] +=
          static_cast<Real>(e.damping[s] / (dt_ * scale2));
    }
    coefficients[std::ptrdiff_t(kernel_.lanes) * (2 * sites_around + own)] =
        static_cast<Real>(e.volume / body.cell_volume() / (64.0 * 64));
  }
}

/// Where other particles matter to one: plane_below, plane_above.
template <class Real>
std::uint8_t VbdSolver<Real>::planes_of(const Real* coefficients) const {
  const auto any = [&](int first, int last) {
    for (int n = first; n < last; ++n)
      if (coefficients[std::ptrdiff_t(kernel_.lanes) * n] != 0) return true;
    return false;
  };
  constexpr int level = sites_around / 3, volumes = 2 * sites_around;
  const bool below =
      any(0, level) || any(sites_around, sites_around + level) || any(volumes + 4, volumes + 8);
  const bool above = any(2 * level, 3 * level) || any(sites_around + 2 * level, 2 * sites_around) ||
                     any(volumes, volumes + 4);
  return std::uint8_t((below ? plane_below : 0) | (above ? plane_above : 0));
}

template <class Real>
void VbdSolver<Real>::begin_step(double t) {
  passes_ = 0;
  particles_.predict(dt_, target_);
  guess();
  if (!near_) return;
  const Streams<Real> u = particles_.moved();
  near_->begin_step(t + dt_, dt_, particles_.before(), particles_.velocity_before(),
                    {{u.axis[0], u.axis[1], u.axis[2]}});
  near_->put_in_front(particles_.before(), u);
  if (const std::optional<Plane> plane = near_->impact(dt_)) shorten_guess(plane->normal);
}

/// An impact that few passes cannot spread through a stiff body would leave the strain of the whole way that
/// it came: of the guess along the plane's normal all, 1/2, 1/4, 1/8 or nothing, whatever has the least
/// objective.
template <class Real>
void VbdSolver<Real>::shorten_guess(const Vec3& normal) {
  const Field<Real> whole = particles_.displacement();
  Field<Real> best = whole;
  double least = objective();
  for (const double share : {0.5, 0.25, 0.125, 0.0}) {
    for (const std::ptrdiff_t i : particles_.index()) {
      const Vec3 u = whole.at(i);
      particles_.displacement().set(
          i, u - (1 - share) * normal.dot(u) * particles_.free_axes(i).cwiseProduct(normal));
    }
    near_->put_in_front(particles_.before(), particles_.moved());
    if (const double value = objective(); value < least) {
      least = value;
      best = particles_.displacement();
    }
  }
  particles_.displacement() = best;
}

/// What passes minimise, without damping [J].
template <class Real>
double VbdSolver<Real>::objective() {
  const std::vector<std::ptrdiff_t>&index = particles_.index(), &sites = particles_.body().sites();
  const Field<Real>& u = particles_.displacement();
  const ConstStreams<Real> before = particles_.before();
  Field<Real> x(springs_.size());
  double inertia = 0;
  for (std::size_t p = 0; p < sites.size(); ++p) {
    const std::ptrdiff_t i = index[p];
    const Vec3 moved = u.at(i);
    x.set(sites[p], Vec3(before.axis[0][i], before.axis[1][i], before.axis[2][i]) + moved);
    inertia += particles_.body().mass(sites[p]) * (moved - target_.at(i)).squaredNorm();
  }
  const StoredEnergy stored = springs_.stored_energy(x);
  return inertia / (2 * dt_ * dt_) + stored.elastic + stored.volume;
}

/// u holds dt v.
template <class Real>
void VbdSolver<Real>::guess() {
  const double g = gravity_.norm(), dt2 = dt_ * dt_;
  const bool touches = near_ && near_->pushes();
  const Vec3 down = g > 0 ? Vec3(gravity_ / g) : Vec3(Vec3::Zero());
  const Streams<Real> u = particles_.moved();
  const ConstStreams<Real> w = particles_.inverse_mass();
  const std::vector<std::ptrdiff_t>& index = particles_.index();
  parallel_in_groups(system_, std::ptrdiff_t(index.size()), 256, [&](std::ptrdiff_t p) {
    const std::ptrdiff_t i = index[std::size_t(p)];
    Vec3 drift, change = dt2 * gravity_;
    for (int axis = 0; axis < 3; ++axis) drift[axis] = double(u.axis[axis][i]);
    if (has_step_before_) {
      change = drift - drift_.at(i);
      const double along = std::clamp(down.dot(change), 0.0, dt2 * g);
      Vec3 across = touches ? Vec3(change - down.dot(change) * down) : Vec3(Vec3::Zero());
      if (const double size = across.norm(); size > dt2 * g) across *= dt2 * g / size;
      change = along * down + across;
    }
    drift_.set(i, drift);
    for (int axis = 0; axis < 3; ++axis)
      if (w.axis[axis][i] > 0) u.axis[axis][i] = static_cast<Real>(drift[axis] + change[axis]);
  });
  has_step_before_ = true;
}

template <class Real>
void VbdSolver<Real>::end_passes() {
  if (near_) near_->end_passes(dt_, particles_.before(), particles_.moved());
}

template <class Real>
void VbdSolver<Real>::rebound(State<Real>& state) const {
  if (near_) near_->rebound({.dt = dt_, .drift = 1}, state);
}

template <class Real>
bool VertexContact<Real>::touches(std::ptrdiff_t index, int count) const {
  for (int lane = 0; lane < count; ++lane)
    if (near_.near(index + lane)) return true;
  return false;
}

template <class Real>
void VertexContact<Real>::move(std::ptrdiff_t index, const Real (&hessian)[6], const Real (&force)[3],
                               const Real (&u)[3]) const {
  auto* near = near_.near(index);
  if (!near) return;
  const auto h = [&](int entry) { return double(hessian[entry]); };
  VertexModel model;
  model.hessian << h(0), h(5), h(4), h(5), h(1), h(3), h(4), h(3), h(2);
  model.force = {double(force[0]), double(force[1]), double(force[2])};
  const ConstStreams<Real> before = particles_.before(), w = particles_.inverse_mass();
  Vec3 x, free;
  for (int axis = 0; axis < 3; ++axis) {
    x[axis] = double(before.axis[axis][index]);
    free[axis] = w.axis[axis][index] > 0 ? 1 : 0;
  }
  const Vec3 start{double(u[0]), double(u[1]), double(u[2])}, way = near_.way(*near, x + start);
  std::vector<Plane> scratch;
  const Vec3 by = move_in_cone(near_.planes(*near, scratch), near->gap, free, x + way, start - way, model,
                               near->normal),
             moved = start + by;
  keep(model.hessian * by - model.force, free, *near);
  const Streams<Real> to = particles_.moved();
  for (int axis = 0; axis < 3; ++axis)
    if (free[axis] > 0) to.axis[axis][index] = static_cast<Real>(moved[axis]);
}

/// Leaves in the multipliers what holds a particle, forces whose pressures are there, times the step's
/// square.
template <class Real>
void VertexContact<Real>::keep(const Vec3& force, const Vec3& free,
                               typename DisplacementContact<Real>::Near& near) const {
  std::vector<std::size_t> on;
  for (std::size_t p = 0; p < near.normal.size(); ++p)
    if (near.normal[p] > 0) on.push_back(p);
  std::vector<Plane> scratch;
  const std::vector<Plane>& planes = near_.planes(near, scratch);
  const std::vector<Vec3> parts = split_by_plane(planes, on, free, force);
  for (std::size_t p = 0; p < near.normal.size(); ++p) {
    const Vec3 normal = free.cwiseProduct(planes[p].normal);
    near.tangential[p] = dt_ * dt_ * (parts[p] - near.normal[p] * normal);
    near.normal[p] *= dt_ * dt_;
  }
}

template <class Real>
Descent<Real> VbdSolver<Real>::part_of(int colour) {
  const Body& body = particles_.body();
  Descent<Real> p{};
  p.entry = blocks_.entries(colour).data();
  p.dictionary = dictionary_.data();
  p.planes = planes_.data();
  for (int n = 0; n < sites_around; ++n) {
    const int dx = n % 3 - 1, dy = n / 3 % 3 - 1, dz = n / 9 - 1;
    p.around[n] = particles_.lattice().neighbour(colour, dx, dy, dz);
    if (const int axes = dx * dx + dy * dy + dz * dz; axes > 0)
      p.rest_length[n] =
          static_cast<Real>(body.rest_length(SpringSlot::Class(axes - 1)) / kernel_.rsqrt_scale);
  }
  p.rest_volume = static_cast<Real>(64 * body.cell_volume());
  p.before = particles_.before();
  p.target = {{target_.axis(0), target_.axis(1), target_.axis(2)}};
  p.inverse_mass = particles_.inverse_mass();
  p.moved = particles_.moved();
  p.contact = contact_.get();
  return p;
}

template <class Real>
void VbdSolver<Real>::pass() {
  const auto pass = damped_ ? kernel_.damped : kernel_.undamped;
  for_each_colour(
      system_, particles_.lattice(), blocks_, kernel_.lanes,
      [&](int colour, std::ptrdiff_t first, std::ptrdiff_t last) {
        pass(parts_[std::size_t(colour)], first, last);
      },
      [](int, std::ptrdiff_t) {});
}

template <class Real>
void VbdSolver<Real>::iterate() {
  if (last_.size() == 0) return pass();
  Field<Real>& u = particles_.displacement();
  std::swap(one_before_, last_);
  last_.array() = u.array();
  pass();
  ++passes_;
  weight_ = passes_ == 1 ? 1 : passes_ == 2 ? 2 / (2 - squared_radius_) : 4 / (4 - squared_radius_ * weight_);
  if (passes_ == 1) return;
  const Real weight = static_cast<Real>(weight_);
  u.array() = weight * (u.array() - one_before_.array()) + one_before_.array();
}

template <class Real>
void VbdSolver<Real>::iterate_into_next_step() {
  iterate();
  passes_ = 0;
  particles_.proceed(dt_, target_);
  guess();
}

template class VertexContact<float>;
template class VertexContact<double>;
template class VbdSolver<float>;
template class VbdSolver<double>;

}  // namespace mss
