#include "integrators/device/vbd_steps.hpp"

#include <algorithm>

#include "core/base/error.hpp"

namespace mss {

template <class Real>
VbdSteps<Real>::VbdSteps(const IntegratorOptions& options)
    : DisplacedSteps<Real>(options.dt, std::max(1, options.iterations)),
      squared_radius_(options.chebyshev_radius * options.chebyshev_radius) {}

template <class Real>
void VbdSteps<Real>::begin(DeviceSystem<Real>& system) {
  if (system.has_planes())
    throw InputError(
        "vbd on a device does not do planes; leave them out, give solve.integrator = \"xpbd\", or give "
        "device = \"cpu\"");
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
}

template <class Real>
void VbdSteps<Real>::begin_passes(DeviceSystem<Real>& system, double t) {
  this->displacement(system, t, {"GUESS"})
      .set("has_step_before", has_step_before_ ? 1 : 0)
      .bind(5, target_)
      .bind(6, drift_)
      .run(system.sites());
  has_step_before_ = true;
  passes_done_ = 0;
}

template <class Real>
void VbdSteps<Real>::descend(DeviceSystem<Real>& system) {
  for (int colour = 0; colour < SitesByColour::colours; ++colour)
    system.program({}, {"neighbours", "vbd"})
        .set("first_particle", particles_->first[std::size_t(colour)])
        .set("step_size", static_cast<Real>(this->dt()))
        .bind(0, system.x())
        .bind(1, target_)
        .bind(2, particle_list_)
        .bind(3, this->u())
        .run(particles_->count(colour));
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
