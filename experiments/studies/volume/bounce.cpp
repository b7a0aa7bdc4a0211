// The cube of `mss volume` falls tilted and bounces: its volume against time, by model and by integrator.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/measures/measures.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/volume/volume.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::volume {

namespace {

constexpr int cells = 4;            ///< per edge
constexpr int samples = 80;         ///< of a run
constexpr double duration = 0.4;    ///< [s]
constexpr double speed = 0.5;       ///< [m/s] at the start
constexpr double density = 10;      ///< [kg/m^3]: waves cross the cube in a twelfth of a second
constexpr double kept_share = 0.8;  ///< step of the runs whose volume against time is kept

/// One model's cube above a plane of restitution 1 without friction.
struct Fall {
  Fall(const VolumeConfig& config, const VolumeModel& m) : model(m), body(cube(m)) {
    Environment environment{.gravity = Vec3(0, 0, -9.81)};
    environment.planes.push_back({.contact = ContactLaw::penalty, .restitution = 1, .friction = 0});
    system = config.make(m.model, body, environment);
    const SpectralBound bound = system->spectral_bound();
    limit = central_limit(bound.omega, bound.damping);
  }

  static BodyConfig cube(const VolumeModel& model) {
    BodyConfig body = volume_cube(model, cells);
    body.density = density;
    body.damping = {.law = Damping::Law::ratio, .zeta = 0.05};
    return body;
  }

  /// Tilted, its lowest corner 0.01 m above the plane.
  State<double> start() const {
    State<double> state = system->rest_state();
    const Eigen::AngleAxisd turn(0.1, Vec3(1, 0.6, 0.2).normalized());
    double lowest = 1;
    for (const std::ptrdiff_t site : body.sites()) {
      state.x.set(site, turn * body.rest_position(site));
      state.v.set(site, {0, 0, -speed});
      lowest = std::min(lowest, state.x.at(site)[2]);
    }
    for (const std::ptrdiff_t site : body.sites())
      state.x.set(site, state.x.at(site) + Vec3(0, 0, 0.01 - lowest));
    return state;
  }

  const VolumeModel& model;
  Body body;
  std::unique_ptr<BodySystem<double>> system;
  double limit;  ///< guaranteed to central differences, by a bound of the frequencies [s]
};

/// The limit of the body at rest by its own stiffness and damping, beside the guaranteed one.
void add_limit(const Fall& fall, Table& limits) {
  Work work;
  const PredictedStep limit =
      predicted_step(find_integrator("verlet"), *fall.system, fall.system->undeformed_state(), work);
  limits.add(
      {fall.model.name, limit.dt, fall.limit, limit.dt / fall.limit, std::string(to_string(limit.status))});
}

/// Volume against time.
struct History {
  Status status = Status::ok;
  bool refused = false;
  std::vector<double> t{}, drift{}, thesis{}, worst{};
};

/// Runs with steps of a share of the limit; 0: with an adaptive method's own.
History run_sampled(const Fall& fall, const std::string& integrator, double share) {
  IntegratorOptions options{.dt = share * fall.limit, .tolerance = 1e-5};
  scale_errors(options, *fall.system);
  const auto method = find_integrator(integrator).make<double>(options);
  State<double> state = fall.start();
  History history;
  Work work;
  for (int i = 1; i <= samples; ++i) {
    try {
      history.status = method->advance(*fall.system, state, i * duration / samples, work);
    } catch (const InputError&) {  // penalty planes in steps that are too long for it
      history.refused = true;
      break;
    }
    const Measures m = measure(*fall.system, state);
    // A body of a hundred times its volume has blown up.
    if (history.status == Status::ok && !(std::abs(m.volume_ratio) < 100))
      history.status = Status::non_finite;
    if (history.status != Status::ok) break;
    history.t.push_back(state.t);
    history.drift.push_back(m.volume_ratio - 1);
    history.thesis.push_back(m.volume_ratio_thesis - 1);
    history.worst.push_back(worst_cell(fall.body, state.x));
  }
  return history;
}

/// Largest difference of the drift from that of the reference, which is interpolated in time.
double difference(const History& a, const History& reference) {
  double largest = 0;
  for (std::size_t i = 0; i < a.t.size(); ++i) {
    const auto next =
        std::size_t(std::upper_bound(reference.t.begin(), reference.t.end(), a.t[i]) - reference.t.begin());
    const std::size_t right = std::clamp<std::size_t>(next, 1, reference.t.size() - 1), left = right - 1;
    const double share = (a.t[i] - reference.t[left]) / (reference.t[right] - reference.t[left]);
    const double drift = reference.drift[left] + share * (reference.drift[right] - reference.drift[left]);
    largest = std::max(largest, std::abs(a.drift[i] - drift));
  }
  return largest;
}

void keep(const Fall& fall, const std::string& integrator, double share, const History& history,
          Table& table) {
  for (std::size_t i = 0; i < history.t.size(); ++i)
    table.add({fall.model.name, integrator, share, history.t[i], history.drift[i], history.thesis[i],
               history.worst[i]});
}

/// The number furthest from zero.
double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end(),
                           [](double a, double b) { return std::abs(a) < std::abs(b); });
}

VolumeRow row_of(const Fall& fall, const std::string& integrator, double share, const History& history,
                 const History& reference) {
  VolumeRow row{.study = Study::bounce,
                .model = fall.model.name,
                .integrator = integrator,
                .cells = cells,
                .step = share,
                .springs = fall.body.config().springs,
                .refused = history.refused,
                .status = history.status};
  if (row.refused || row.status != Status::ok) return row;
  row.drift = largest(history.drift);
  row.drift_thesis = largest(history.thesis);
  row.worst_cell = largest(history.worst);
  row.difference = difference(history, reference);
  return row;
}

}  // namespace

VolumeTables measure_bounce(const VolumeConfig& config, const VolumeModel& model) {
  VolumeTables tables{empty_rows(), empty_bounce(), empty_limit()};
  const Fall fall(config, model);
  const History reference = run_sampled(fall, "rk4", reference_bounce_step);
  keep(fall, "rk4", reference_bounce_step, reference, tables.bounce);
  add_row(tables.rows, row_of(fall, "rk4", reference_bounce_step, reference, reference));
  if (model.filling != detailed_filling || model.poisson != detailed_poisson ||
      reference.status != Status::ok)
    return tables;
  add_limit(fall, tables.limit);
  for (const std::string& integrator : config.integrators) {
    const bool fixed = find_integrator(integrator).stepping == Stepping::fixed;
    for (const double share : fixed ? config.step_shares : std::vector<double>{0}) {
      const History history = run_sampled(fall, integrator, share);
      add_row(tables.rows, row_of(fall, integrator, share, history, reference));
      if (share == kept_share || !fixed) keep(fall, integrator, share, history, tables.bounce);
    }
  }
  return tables;
}

}  // namespace mss::studies::volume
