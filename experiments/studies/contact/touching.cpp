// Bodies that touch: the system and the steps of the studies about them.
#include "experiments/studies/contact/touching.hpp"

#include <Eigen/Geometry>

#include "core/springs/spring_system.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::contact {

TouchingBodies::TouchingBodies(const std::vector<BodyConfig>& configs, const Environment& environment,
                               const std::string& integrator, double share_of_step,
                               const BodiesSystem<double>::Surfaces& surfaces) {
  BodiesSystem<double>::Bodies systems;
  for (std::size_t i = 0; i < configs.size(); ++i)
    systems.push_back(std::make_unique<SpringSystem<double>>(
        bodies_.emplace_back(configs[i]),
        environment_of_body(environment, i < surfaces.size() ? surfaces[i] : nullptr),
        Execution{.threads = 1}));
  system_ = std::make_unique<BodiesSystem<double>>(std::move(systems), environment, surfaces, 1);
  state_ = system_->rest_state();
  const IntegratorInfo& info = find_integrator(integrator);
  dt_ = share_of_step * safe_share * stable_step(info, system_->spectral_bound());
  method_ = info.make<double>({.dt = dt_});
}

void TouchingBodies::push(std::size_t body, const Vec3& velocity, const Vec3& angular_velocity) {
  const Vec3 centre = mean(body, state_.x);
  const Level& level = system_->levels()[body];
  for (const std::ptrdiff_t own : level.body.sites()) {
    const std::ptrdiff_t site = level.first + own;
    state_.v.set(site,
                 state_.v.at(site) + velocity + angular_velocity.cross(Vec3(state_.x.at(site) - centre)));
  }
}

Status TouchingBodies::step() { return method_->advance(*system_, state_, state_.t + dt_, work_); }

Vec3 TouchingBodies::mean(std::size_t body, const Field<double>& field) const {
  const Level& level = system_->levels()[body];
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : level.body.sites())
    sum += level.body.mass(site) / level.body.total_mass() * field.at(level.first + site);
  return sum;
}

double TouchingBodies::kinetic() const {
  double twice = 0;
  for (const Level& level : system_->levels())
    for (const std::ptrdiff_t site : level.body.sites())
      twice += level.body.mass(site) * state_.v.at(level.first + site).squaredNorm();
  return twice / 2;
}

double TouchingBodies::energy() const {
  const StoredEnergy stored = system_->stored_energy(state_.x);
  return kinetic() + stored.elastic + stored.volume + system_->outer_potential(state_.t, state_.x);
}

}  // namespace mss::studies::contact
