#include "core/springs/spring_system.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "core/forces/cell_geometry.hpp"
#include "core/forces/fold_guard.hpp"
#include "core/forces/spring_law.hpp"
#include "core/springs/cell_virials.hpp"
#include "core/springs/element_tangents.hpp"
#include "core/springs/maxwell_branches.hpp"
#include "core/springs/sweep_pipeline.hpp"

namespace mss {

namespace {

template <class Real>
SweepKernel<Real> find_kernel(const std::string& name) {
  const auto& kernels = runnable_copies<SweepKernel<Real>>();
  if (name.empty()) return kernels.back();
  std::string known;
  for (const auto& kernel : kernels) {
    if (kernel.name == name) return kernel;
    known += (known.empty() ? "" : ", ") + std::string(kernel.name);
  }
  throw InputError(
      fmt::format("kernel '{}' is unknown or needs another processor; this one runs {}", name, known));
}

/// The requested number of threads, at most one a plane; by default as many as pay: what a step of 2000
/// springs a thread takes, some 4 us, is a few times what it costs to share it. Where several ranks share the
/// body, they have the cores already.
int team_size(const Body& body, int requested) {
  const int planes = body.own_planes().last;
  if (requested == 0 && body.ranks().are_several()) return 1;
  if (requested > 0) return std::min(requested, planes);
  const int worth_it = int(std::min<std::size_t>(body.spring_count() / 2000, 1024));
  return std::clamp(std::min(available_cores(), worth_it), 1, planes);
}

}  // namespace

template <class Real>
SpringSystem<Real>::SpringSystem(const Body& body, const Environment& environment, const Execution& execution)
    : SpringSystem(body, environment, find_kernel<Real>(execution.kernel), execution) {}

template <class Real>
SpringSystem<Real>::SpringSystem(const Body& body, const Environment& environment,
                                 const SweepKernel<Real>& kernel, const Execution& execution)
    : BodySystem<Real>(body, environment, mss::spectral_bound(body), team_size(body, execution.threads),
                       execution.sleep),
      tangents_(*this),
      discrete_gradient_(body),
      pipeline_(std::make_unique<SweepPipeline<Real>>(*this, this->team(), this->sleep_tracker(), kernel)),
      branches_(body.config().relaxation.acts() ? std::make_unique<MaxwellBranches<Real>>(*this, body)
                                                : nullptr) {
  if (branches_ && execution.sleep.bound > 0)
    throw InputError(
        "material.relaxation goes on in a body at rest, so nothing falls asleep; leave solve.sleep out");
}

template <class Real>
SpringSystem<Real>::~SpringSystem() = default;

template <class Real>
StoredEnergy SpringSystem<Real>::stored_energy(const Field<Real>& x) const {
  StoredEnergy energy;
  const Communicator& ranks = this->body().ranks();
  ranks.add_in_order(energy, [&] { add_energy_of_springs(x, energy); });
  ranks.add_in_order(energy, [&] { add_energy_of_cells(x, energy); });
  if (branches_) energy.relaxing = branches_->energy(x);
  return energy;
}

template <class Real>
double SpringSystem<Real>::dissipated_by_relaxation() const {
  return branches_ ? branches_->dissipated() : 0;
}

template <class Real>
StepMemory<Real>* SpringSystem<Real>::memory() {
  return branches_.get();
}

template <class Real>
void SpringSystem<Real>::remember(Record& record) {
  BodySystem<Real>::remember(record);
  if (branches_) branches_->remember(record);
}

template <class Real>
void SpringSystem<Real>::add_energy_of_springs(const Field<Real>& x, StoredEnergy& energy) const {
  this->body().for_each_spring(
      [&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double stiffness, double) {
        energy.elastic +=
            spring_energy(stiffness, this->body().rest_length(slot.kind), (x.at(b) - x.at(a)).norm());
      });
}

template <class Real>
void SpringSystem<Real>::add_energy_of_cells(const Field<Real>& x, StoredEnergy& energy) const {
  const double rest = this->body().cell_volume(), size = this->body().config().cell_size;
  this->body().for_each_cell([&](std::ptrdiff_t site) {
    const SiteWeights& weights = this->body().weights_at(site);
    const double volume = weights.volume * this->body().kinds().interior_volume(),
                 guard = weights.fold_guard * this->body().kinds().interior_fold_guard();
    const double change = thesis_volume(corners_of(this->body(), x, site)) - rest;
    energy.volume += 0.5 * volume * change * change / rest;
    if (guard != 0)
      energy.elastic += fold_guard_energy(guarded_corner_stiffness(guard, size), guarded_length(size),
                                          corners_of(this->body(), x, site));
  });
}

template <class Real>
std::optional<std::vector<Eigen::Matrix3d>> SpringSystem<Real>::cell_virials(const Field<Real>& x,
                                                                             const Field<Real>& v) const {
  std::vector<Eigen::Matrix3d> virials;
  for (const Level& level : this->levels()) append_virials(level, x, v, virials);
  return virials;
}

template <class Real>
void SpringSystem<Real>::force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) {
  pipeline_->run({.finish = Pass::force, .t = t, .dt = 0, .x = &x, .v = &v, .out = &f}, 1);
  if (branches_) branches_->add_force(t, x, f);
  this->add_gravity(f);
  this->add_penalty_force(t, x, v, f);
}

template <class Real>
void SpringSystem<Real>::acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  pipeline_->run({.finish = Pass::acceleration, .t = t, .dt = 0, .x = &x, .v = &v, .out = &a}, 1);
  stop_sleeping(a);
  if (branches_) branches_->add_acceleration(t, x, a);
  this->add_penalty_acceleration(t, x, v, a);
  this->stop_sticking(t, x, v, a);
  this->held().clear(a);
}

/// Zeroes the accelerations of planes that sleep.
template <class Real>
void SpringSystem<Real>::stop_sleeping(Field<Real>& a) const {
  if (!this->sleep_tracker()) return;
  const Lattice& lattice = this->body().lattice();
  for (int plane = 0; plane < lattice.planes(); ++plane)
    for (int axis = 0; axis < 3 && this->sleep_tracker()->asleep(plane); ++axis)
      std::fill_n(a.axis(axis) + lattice.plane * plane, lattice.plane, Real(0));
}

template <class Real>
void SpringSystem<Real>::SpringTangents::add(double t, const Field<Real>& x, const Field<Real>& v,
                                             const TangentCoefficients& sum, BlockMatrix& blocks) {
  add_tangent(this->body(), x, v, sum, blocks);
  if (system_.branches_) system_.branches_->add_tangent(t, x, sum, blocks);
}

template <class Real>
void SpringSystem<Real>::SpringTangents::add_diagonal(double t, const Field<Real>& x, const Field<Real>&,
                                                      const TangentCoefficients& sum,
                                                      std::vector<Eigen::Matrix3d>& diagonal) {
  if (straight_.size() == 0) straight_ = mixed_ = Field<Real>(system_.size());
  system_.diagonal_blocks(x, sum, straight_, mixed_);
  for (std::size_t p = 0; p < diagonal.size(); ++p) {
    const std::ptrdiff_t site = system_.particles()[p];
    diagonal[p].diagonal() += straight_.at(site);
    const Vec3 mixed = mixed_.at(site);
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      diagonal[p](b, c) += mixed[a];
      diagonal[p](c, b) += mixed[a];
    }
  }
  if (system_.branches_) system_.branches_->add_diagonal(t, x, sum, diagonal);
}

template <class Real>
void SpringSystem<Real>::SpringTangents::multiply(double t, const Field<Real>& x, const Field<Real>&,
                                                  const TangentCoefficients& sum, const Field<Real>& p,
                                                  Field<Real>& out) {
  system_.pipeline_->run(
      {.finish = Pass::product, .t = t, .dt = 0, .x = &x, .v = &p, .out = &out, .sum = sum}, 1);
  if (system_.branches_) system_.branches_->add_product(t, x, sum, p, out);
}

template <class Real>
void SpringSystem<Real>::diagonal_blocks(const Field<Real>& x, const TangentCoefficients& sum,
                                         Field<Real>& straight, Field<Real>& mixed, bool springs) {
  Pass pass{.finish = Pass::straight_diagonal, .t = 0, .dt = 0, .x = &x, .v = &x, .out = &straight};
  pass.sum = sum;
  pass.springs = springs;
  if (!springs) pass.sum.damping = 0;
  pipeline_->run(pass, 1);
  pass.finish = Pass::mixed_diagonal;
  pass.out = &mixed;
  pipeline_->run(pass, 1);
}

template <class Real>
void SpringSystem<Real>::kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) {
  if (this->contact().has_penalties() || branches_) return System<Real>::kick_drift(update, dt, steps, state);
  pipeline_->run({.finish = Pass::kick_drift,
                  .t = state.t,
                  .dt = dt,
                  .x = &state.x,
                  .v = &state.v,
                  .state = &state,
                  .update = update},
                 steps);
  state.t += double(steps) * dt;
}

template <class Real>
void SpringSystem<Real>::apply(const KickDrift& update, const Field<Real>& a, double dt,
                               State<Real>& state) const {
  pipeline_->apply(update, a, state);
  kicked_for(*this, update.kick_before + update.kick_after);
  state.t += dt;
  this->constrain(state.t, state.x, state.v);
}

template <class Real>
const SweepKernel<Real>& SpringSystem<Real>::kernel() const {
  return pipeline_->kernel();
}

template <class Real>
const char* SpringSystem<Real>::kernel_name() const {
  return kernel().name;
}

template <class Real>
void SpringSystem<Real>::update_ghosts(const State<Real>& state) const {
  pipeline_->update_ghosts(state);
}

template class SpringSystem<float>;
template class SpringSystem<double>;

}  // namespace mss
