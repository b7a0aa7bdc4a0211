#include "experiments/simulation/landing.hpp"

#include <cmath>

#include "core/measures/measures.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/model.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/integrator.hpp"

namespace mss {

namespace {

constexpr double at_rest = 1e-6;  ///< largest stretch of a recovered body

const IntegratorInfo& method() { return find_integrator("verlet"); }

}  // namespace

std::string_view to_string(Recovery outcome) {
  switch (outcome) {
    case Recovery::recovered:
      return "recovered";
    case Recovery::mirrored:
      return "mirrored";
    case Recovery::trapped:
      return "trapped";
    case Recovery::moving:
      return "moving";
    case Recovery::non_finite:
      return "non_finite";
  }
  return "unknown";
}

double trial_step(const BodySystem<double>& system) {
  return 0.1 * stable_step(method(), system.spectral_bound());
}

RecoveryTrial settle(BodySystem<double>& system, State<double>& state, double dt) {
  constexpr long sample_steps = 128, most_samples = 500;
  constexpr int samples_to_trapped = 50;
  constexpr double energy_tolerance = 1e-9;
  const double interval = double(sample_steps) * trial_step(system);
  const auto integrator = method().make<double>({.dt = dt});
  Work work;
  double before = no_value;
  int unchanged = 0;
  RecoveryTrial trial{.outcome = Recovery::moving};
  for (long i = 1; i <= most_samples; ++i) {
    const Status status = integrator->advance(system, state, double(i) * interval, work);
    const Measures m = measure(system, state);
    const double stored = m.elastic + m.volume_energy;
    trial.seconds = state.t;
    if (status != Status::ok || !std::isfinite(stored))
      return {.outcome = Recovery::non_finite,
              .seconds = state.t,
              .max_stretch = no_value,
              .min_jacobian = no_value};
    trial.max_stretch = m.max_stretch;
    trial.min_jacobian = m.min_jacobian;
    unchanged = std::abs(stored - before) <= energy_tolerance * stored ? unchanged + 1 : 0;
    before = stored;
    if (m.max_stretch < at_rest)
      trial.outcome = m.min_jacobian > 0 ? Recovery::recovered : Recovery::mirrored;
    if (unchanged == samples_to_trapped) trial.outcome = Recovery::trapped;
    if (trial.outcome != Recovery::moving) break;
  }
  return trial;
}

const std::vector<Landing>& landings() {
  static const std::vector<Landing> all{
      {"corner", Vec3(1, 1, 1).normalized()}, {"edge", Vec3(0, 1, 1).normalized()}, {"face", Vec3::UnitZ()}};
  return all;
}

RecoveryTrial try_landing(const std::string& model, BodyConfig config, const Plane& ground, double speed,
                          double dt) {
  constexpr double above = 1e-3;  // of a cell
  config.origin = above * config.cell_size * Vec3::Ones();
  const Body body(config);
  const auto system = make_system<double>(model, body, {.planes = {ground}}, 1);
  State<double> state = system->rest_state();
  for (const std::ptrdiff_t site : system->particles()) state.v.set(site, -speed * ground.normal);
  RecoveryTrial trial = settle(*system, state, dt > 0 ? dt : trial_step(*system));
  const bool inverted = !(trial.min_jacobian > 0);
  if (!inverted && (trial.outcome == Recovery::trapped || trial.outcome == Recovery::moving))
    trial.outcome = Recovery::recovered;
  return trial;
}

}  // namespace mss
