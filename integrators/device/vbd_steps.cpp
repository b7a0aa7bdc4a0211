#include "integrators/device/vbd_steps.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/environment/plane_bounds.hpp"

namespace mss {

template <class Real>
VbdSteps<Real>::VbdSteps(const IntegratorOptions& options)
    : DisplacedSteps<Real>(options.dt, std::max(1, options.iterations)),
      squared_radius_(options.chebyshev_radius * options.chebyshev_radius) {}

template <class Real>
void VbdSteps<Real>::begin(DeviceSystem<Real>& system) {
  DisplacedSteps<Real>::begin(system);
  const Body& body = system.springs().body();
  particles_.emplace(body.lattice(), body.sites());
  particle_list_ = memory_of(system.shared_device(),
                             std::vector<std::uint32_t>(particles_->sites.begin(), particles_->sites.end()));
  target_ = system.make_vectors();
  drift_ = system.make_vectors();
  if (squared_radius_ > 0) last_ = system.make_vectors(), one_before_ = system.make_vectors();
}

template <class Real>
void VbdSteps<Real>::remember(DeviceSystem<Real>& system, Record& record) {
  record.keep(has_step_before_);
  Field<Real> drift(system.springs().size());
  system.read(drift_, drift);
  record.keep_field(drift, system.springs().size());
  if (record.reads()) system.write(drift, drift_);
  if (auto* contact = this->contact()) contact->remember(system, record);
}

template <class Real>
void VbdSteps<Real>::displace(DeviceSystem<Real>& system, double t) {
  ShaderProgram& program = this->displacement(system, t, {"GUESS"});
  if (auto* contact = this->contact()) program.bind(7, contact->pushes());
  program.set("has_step_before", has_step_before_ ? 1 : 0)
      .bind(5, target_)
      .bind(6, drift_)
      .run(system.sites());
  has_step_before_ = true;
}

template <class Real>
void VbdSteps<Real>::begin_passes(DeviceSystem<Real>& system) {
  passes_done_ = 0;
  auto* contact = this->contact();
  if (!contact) return;
  contact->put_in_front(system, this->dt(), this->u());
  if (const int plane = contact->impact(); plane >= 0)
    shorten_guess(system, system.springs().bounds()->planes()[std::size_t(plane)].normal);
}

/// See VbdSolver::shorten_guess(). Impacts are few, so the processor weighs the guesses.
template <class Real>
void VbdSteps<Real>::shorten_guess(DeviceSystem<Real>& system, const Vec3& normal) {
  Field<Real> whole(system.springs().size());
  system.read(this->u(), whole);
  Field<Real> best = whole, u = whole, x(whole), target(whole);
  system.read(system.x(), x);
  system.read(target_, target);
  double least = objective(system.springs(), x, target, whole);
  for (const double share : {0.5, 0.25, 0.125, 0.0}) {
    for (const std::ptrdiff_t site : system.springs().particles()) {
      const Vec3 moved = whole.at(site);
      u.set(site, moved - (1 - share) * normal.dot(moved) *
                              system.springs().bounds()->free_axes(site).cwiseProduct(normal));
    }
    system.write(u, this->u());
    this->contact()->put_in_front(system, this->dt(), this->u());
    system.read(this->u(), u);
    if (const double value = objective(system.springs(), x, target, u); value < least) {
      least = value;
      best = u;
    }
  }
  system.write(best, this->u());
}

/// See VbdSolver::objective() [J].
template <class Real>
double VbdSteps<Real>::objective(const SpringSystem<Real>& springs, const Field<Real>& x,
                                 const Field<Real>& target, const Field<Real>& u) const {
  Field<Real> moved = x;
  double inertia = 0;
  for (const std::ptrdiff_t site : springs.particles()) {
    inertia += springs.body().mass(site) * (u.at(site) - target.at(site)).squaredNorm();
    moved.set(site, x.at(site) + u.at(site));
  }
  const StoredEnergy stored = springs.stored_energy(moved);
  return inertia / (2 * this->dt() * this->dt()) + stored.elastic + stored.volume;
}

template <class Real>
void VbdSteps<Real>::descend(DeviceSystem<Real>& system) {
  auto* contact = this->contact();
  std::vector<std::string> words, parts{"neighbours"};
  if (contact) {
    words.push_back(fmt::format("PLANE_COUNT {}", system.springs().bounds()->planes().size()));
    parts.insert(parts.end(), contact->parts.begin(), contact->parts.end());
    parts.emplace_back("block_in_cone");
  }
  parts.emplace_back("vbd");
  ShaderProgram& program = system.program(words, parts);
  if (contact) contact->set_planes(system, program);
  program.set("step_size", static_cast<Real>(this->dt()));
  program.bind(0, system.x()).bind(1, target_).bind(2, particle_list_).bind(3, this->u());
  for (int colour = 0; colour < SitesByColour::colours; ++colour)
    program.set("first_particle", particles_->first[std::size_t(colour)]).run(particles_->count(colour));
}

/// See VbdSolver::iterate().
template <class Real>
void VbdSteps<Real>::pass(DeviceSystem<Real>& system) {
  if (squared_radius_ == 0) return descend(system);
  Vectors& u = this->u();
  std::swap(one_before_, last_);
  last_.copy(u);
  descend(system);
  ++passes_done_;
  weight_ = passes_done_ == 1   ? 1
            : passes_done_ == 2 ? 2 / (2 - squared_radius_)
                                : 4 / (4 - squared_radius_ * weight_);
  if (passes_done_ == 1) return;
  system.combine(u, -1, one_before_, u);
  system.combine(one_before_, weight_, u, u);
}

template class VbdSteps<float>;
template class VbdSteps<double>;

}  // namespace mss
