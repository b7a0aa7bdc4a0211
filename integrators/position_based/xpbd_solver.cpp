#include "integrators/position_based/xpbd_solver.hpp"

#include <algorithm>

namespace mss {

namespace {

/// A lane is a cell, or a site with springs: the kind of its elements, from 1, and of its corners' masses.
constexpr int lane_size = 9;

bool has_constraints(const SiteElements& e) {
  return e.volume != 0 ||
         std::any_of(e.stiffness.begin(), e.stiffness.end(), [](double k) { return k != 0; });
}

/// Whether only springs between corners 0 to 3, which lie in one plane, have a stiffness or a damper.
bool is_flat(const SiteElements& e) {
  for (std::size_t s = 0; s < spring_slots.size(); ++s)
    if ((e.stiffness[s] != 0 || e.damping[s] != 0) && (spring_slots[s].a >= 4 || spring_slots[s].b >= 4))
      return false;
  return e.volume == 0;
}

template <class Real>
ColouredBlocks blocks_of(const ColouredParticles<Real>& particles, int lanes) {
  const Body& body = particles.body();
  const auto describe = [&](int colour, const std::array<int, 3>& at, std::ptrdiff_t within,
                            std::uint32_t* numbers) {
    const std::uint32_t kind = body.kind(body.lattice().site(at[0], at[1], at[2]));
    if (!has_constraints(body.kinds().elements(kind))) return;
    numbers[0] = 1 + kind;
    for (int c = 0; c < 8; ++c)
      numbers[1 + c] = particles.mass_kind(within + particles.lattice().corner(colour, c));
  };
  return {particles.lattice(), lanes, lane_size, describe};
}

}  // namespace

template <class Real>
XpbdSolver<Real>::XpbdSolver(const SpringSystem<Real>& springs, System<Real>& system, double dt,
                             bool multipliers)
    : system_(system),
      particles_(springs, system),
      kernel_(fastest_copy<XpbdKernel<Real>>()),
      damped_(springs.body().config().is_damped()),
      keeps_multipliers_(multipliers || particles_.partly_held()),
      dt_(dt),
      blocks_(blocks_of(particles_, kernel_.lanes)) {
  if (system.bounds())
    contact_ = std::make_unique<DisplacementContact<Real>>(*system.bounds(), springs.body(),
                                                           particles_.lattice().size(), particles_.index(),
                                                           system.plane_impulses());
  fill_dictionary();
  for (int colour = 0; colour < ColouredLattice::colours; ++colour) {
    if (keeps_multipliers_)
      multipliers_[std::size_t(colour)] = AlignedArray<Real>(std::ptrdiff_t(blocks_.entries(colour).size()) *
                                                             kernel_.lanes * constraints_per_cell);
    parts_[std::size_t(colour)] = part_of(colour);
  }
}

template <class Real>
void XpbdSolver<Real>::fill_dictionary() {
  const std::ptrdiff_t size = std::ptrdiff_t(projection_coefficients) * kernel_.lanes;
  dictionary_ = AlignedArray<Real>(size * std::ptrdiff_t(blocks_.size()));
  is_flat_.assign(blocks_.size(), 1);
  for (std::size_t entry = 1; entry < blocks_.size(); ++entry)
    for (int lane = 0; lane < kernel_.lanes; ++lane)
      if (const std::uint32_t* numbers = blocks_.lane(entry, lane); numbers[0] != 0) {
        fill_lane(numbers, dictionary_.data() + size * std::ptrdiff_t(entry) + lane);
        if (!is_flat(particles_.body().kinds().elements(numbers[0] - 1))) is_flat_[entry] = 0;
      }
}

template <class Real>
void XpbdSolver<Real>::fill_lane(const std::uint32_t* lane, Real* coefficients) const {
  const SiteElements e = particles_.body().kinds().elements(lane[0] - 1);
  const double scale2 = double(kernel_.rsqrt_scale) * double(kernel_.rsqrt_scale);
  const auto mobility = [&](int corner) { return particles_.masses()[lane[1 + corner]]; };
  for (int s = 0; s < springs_per_site; ++s) {
    const SpringSlot& slot = spring_slots[std::size_t(s)];
    const double stiffness = e.stiffness[std::size_t(s)] * dt_ * dt_,
                 damping = e.damping[std::size_t(s)] * dt_;
    const double g = 1 / ((stiffness + damping) * (mobility(slot.a) + mobility(slot.b)) + 1);
    Real* out = coefficients + std::ptrdiff_t(3) * s * kernel_.lanes;
    out[0] = static_cast<Real>(stiffness * g / scale2);
    out[kernel_.lanes] = static_cast<Real>(damping * g / scale2);
    out[2 * kernel_.lanes] = static_cast<Real>(g);
  }
  coefficients[std::ptrdiff_t(3) * springs_per_site * kernel_.lanes] =
      static_cast<Real>(e.volume * dt_ * dt_ / particles_.body().cell_volume());
}

template <class Real>
void XpbdSolver<Real>::begin_step(double t) {
  particles_.predict(dt_, particles_.displacement());
  forget_multipliers();
  if (contact_) {
    const Streams<Real> u = particles_.moved();
    contact_->begin_step(t + dt_, dt_, particles_.before(), particles_.velocity_before(),
                         {{u.axis[0], u.axis[1], u.axis[2]}});
  }
}

template <class Real>
void XpbdSolver<Real>::end_passes() {
  if (contact_) contact_->end_passes(dt_, particles_.before(), particles_.moved());
}

template <class Real>
void XpbdSolver<Real>::rebound(State<Real>& state) const {
  if (contact_) contact_->rebound({.dt = dt_, .drift = 1}, state);
}

template <class Real>
void XpbdSolver<Real>::forget_multipliers() {
  for (AlignedArray<Real>& multipliers : multipliers_) multipliers.fill(0);
}

template <class Real>
Projection<Real> XpbdSolver<Real>::part_of(int colour) {
  const Body& body = particles_.body();
  Projection<Real> p{};
  p.entry = blocks_.entries(colour).data();
  p.dictionary = dictionary_.data();
  p.is_flat = is_flat_.data();
  p.multipliers = multipliers_[std::size_t(colour)].data();
  for (int c = 0; c < 8; ++c) p.corner[c] = particles_.lattice().corner(colour, c);
  for (std::size_t s = 0; s < spring_slots.size(); ++s)
    p.rest_length[s] = static_cast<Real>(kernel_.rsqrt_scale * body.rest_length(spring_slots[s].kind));
  p.rest_volume = static_cast<Real>(body.cell_volume());
  p.before = particles_.before();
  p.inverse_mass = particles_.inverse_mass();
  p.moved = particles_.moved();
  return p;
}

template <class Real>
template <class Finished>
void XpbdSolver<Real>::pass(Finished&& finished) {
  const auto project = keeps_multipliers_ ? kernel_.general : damped_ ? kernel_.damped : kernel_.undamped;
  for_each_colour(
      system_, particles_.lattice(), blocks_, kernel_.lanes,
      [&](int colour, std::ptrdiff_t first, std::ptrdiff_t last) {
        project(parts_[std::size_t(colour)], first, last);
        if (contact_)
          contact_->project(int(2 * (first / particles_.lattice().plane)) + (colour >> 2),
                            particles_.before(), particles_.moved());
      },
      finished);
}

template <class Real>
void XpbdSolver<Real>::iterate() {
  pass([](int, std::ptrdiff_t) {});
}

template <class Real>
void XpbdSolver<Real>::iterate_into_next_step() {
  pass([&](int parity, std::ptrdiff_t plane) {
    particles_.proceed(dt_, particles_.displacement(), parity, plane);
  });
  forget_multipliers();
}

template class XpbdSolver<float>;
template class XpbdSolver<double>;

}  // namespace mss
