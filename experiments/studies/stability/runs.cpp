// How `mss stability` finds the largest stable step.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "experiments/harness/case_rows.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/disturbance.hpp"
#include "experiments/simulation/equilibrium.hpp"
#include "experiments/studies/stability/stability.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::stability {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double bar_length = 3, bend = std::numbers::pi / 2;  // [m], [rad]

BodyConfig body_of(const StabilityConfig& config, Deformation deformation, int n, double ratio) {
  BodyConfig body = unit_cube({.young = config.young, .poisson = config.poisson}, config.density, n, ratio);
  if (deformation == Deformation::bent) body.voxels = VoxelGrid::box(int(bar_length) * n, n, n);
  return body;
}

/// How much longer the body is between its clamps, relative to its length.
double strain_of(Deformation deformation) {
  return deformation == Deformation::stretched ? 0.3 : deformation == Deformation::compressed ? -0.2 : 0;
}

/// The middle of the circle that a bar is bent to.
const Vec3 bend_centre(0, 0.5, 0.5 - bar_length / bend);

/// Clamps at both ends, in place after a second at the latest.
Environment clamps(Deformation deformation) {
  if (deformation == Deformation::none) return {};
  const double length = deformation == Deformation::bent ? bar_length : 1;
  Hold end{.box = {{length, 0, 0}, {length, 1, 1}}, .displacement = strain_of(deformation) * Vec3::UnitX()};
  if (deformation == Deformation::bent) {
    end.displacement = -length * Vec3::UnitX();
    end.turn = Turn{.axis = Vec3::UnitY(), .centre = bend_centre, .rate = bend, .until = 1};
  }
  return {.holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}, end}};
}

/// Where a particle of the deformed body is, roughly.
Vec3 roughly(Deformation deformation, const Vec3& rest) {
  if (deformation != Deformation::bent) return {(1 + strain_of(deformation)) * rest[0], rest[1], rest[2]};
  const Vec3 section(0, rest[1], rest[2]);
  return bend_centre +
         Eigen::AngleAxisd(bend * rest[0] / bar_length, Vec3::UnitY()) * (section - bend_centre);
}

/// Twice the kinetic energy [J].
double motion(const Specimen& specimen, const State<double>& state) {
  double sum = 0;
  for (const std::ptrdiff_t site : specimen.system.particles())
    sum += specimen.system.mass(site) * state.v.at(site).squaredNorm();
  return sum;
}

/// The equilibrium with particles displaced by at most a millionth of a cell, so that their motion is linear.
State<double> disturbed(const StabilityConfig& config, Specimen& specimen) {
  constexpr double share_of_cell = 1e-6;
  State<double> state = specimen.equilibrium;
  state.x.array() += fast_disturbance(specimen.system, specimen.equilibrium,
                                      share_of_cell * specimen.body.config().cell_size, config.seed)
                         .array();
  return state;
}

/// Twice the energy that a small displacement from equilibrium stores [J]: its product with the forces it
/// causes.
double stored(Specimen& specimen, const State<double>& state) {
  Field<double> force(specimen.system.size()), residual(specimen.system.size());
  const State<double>& rest = specimen.equilibrium;
  specimen.system.acceleration(state.t, state.x, state.v, force);
  specimen.system.acceleration(rest.t, rest.x, rest.v, residual);
  double sum = 0;
  for (const std::ptrdiff_t site : specimen.system.particles())
    sum -= specimen.system.mass(site) *
           (force.at(site) - residual.at(site)).dot(state.x.at(site) - rest.x.at(site));
  return sum;
}

/// Whether a step is stable. Runs a small motion in windows, each twice as long as the one before, and
/// compares their mean kinetic energies. The run ends once it has grown or decayed enough; otherwise the step
/// is stable unless the last mean exceeds the one before by a percent: growth of less than 1e-6 a step is not
/// seen. Means are over every step: at fewer some vibrations would be sampled at one phase only.
bool is_stable(const StabilityConfig& config, const IntegratorInfo& method, Specimen& specimen, double dt) {
  constexpr double grown = 1e4, gone = 1e-10;  // of the initial energy; rounding can reach 1e-11
  constexpr double tolerated = 0.01, obvious = 10;
  constexpr long first_window = 512;
  const long last_window = specimen.ratio > 0 ? 65536 : 16384;
  const auto integrator = method.make<double>({.dt = dt});
  State<double> state = disturbed(config, specimen);
  const double begin = state.t, initial = stored(specimen, state);
  double before = infinity;
  Work work;
  for (long step = 0, window = first_window; window <= last_window; window *= 2) {
    double mean = 0;
    for (const long end = step + window; step < end;) {
      const double t = begin + double(++step) * dt;
      if (integrator->advance(specimen.system, state, t, work) != Status::ok) return false;
      const double now = motion(specimen, state);
      if (!(now < grown * initial)) return false;
      mean += now / double(window);
    }
    if (mean > obvious * before) return false;  // it may yet saturate, and decay
    if (mean < gone * initial) return true;
    if (2 * window > last_window) return mean <= (1 + tolerated) * before;
    before = mean;
  }
  return true;
}

/// A method may be unstable at any step, yet grow too slowly to be seen, or say a wrong limit.
bool is_a_step(double dt) { return dt > 0 && std::isfinite(dt); }

void add_row(const StabilityConfig& config, const IntegratorInfo& method, Specimen& specimen, Table& rows) {
  const double guaranteed = guaranteed_step(method, specimen.system.spectral_bound());
  const auto row = [&](double predicted, double measured, std::string_view status) {
    const double omega = specimen.status == Status::ok ? specimen.omega : no_value;
    rows.add({method.name, std::string(to_string(specimen.deformation)), specimen.cells, specimen.ratio,
              omega, guaranteed, predicted, measured, is_a_step(predicted) ? measured / predicted : no_value,
              std::string(status)});
  };
  if (specimen.status != Status::ok) return row(no_value, no_value, to_string(specimen.status));
  Work work;
  const PredictedStep predicted = predicted_step(method, specimen.system, specimen.equilibrium, work);
  if (predicted.status != Status::ok) return row(no_value, no_value, to_string(predicted.status));
  if (method.resonant_limit && specimen.ratio == 0)
    return row(predicted.dt, no_value, "grows in too few steps to be found");
  const MeasuredStep measured = measure_step(config, method, specimen);
  if (measured.stable == 0) return row(predicted.dt, no_value, "no step is stable");
  if (!std::isfinite(measured.unstable)) return row(predicted.dt, no_value, "every step is stable");
  const double limit = (measured.stable + measured.unstable) / 2;
  if (!is_a_step(predicted.dt))
    return row(predicted.dt, limit,
               predicted.dt > 0 ? "no limit predicted" : "predicted unstable at any step");
  row(predicted.dt, limit, "ok");
}

struct SpecimenChoice {
  Deformation deformation;
  int cells;
  double ratio;

  std::string name() const {
    return fmt::format("deformation {}, {} cells, damping ratio {:g}", to_string(deformation), cells, ratio);
  }
};

Table empty_rows() {
  return Table({{"integrator"},
                {"deformation"},
                {"cells"},
                {"ratio"},
                {"omega_max", "rad/s"},
                {"guaranteed", "s"},
                {"predicted", "s"},
                {"measured", "s"},
                {"measured_over_predicted"},
                {"status"}});
}

Json compute_row(const StabilityConfig& config, const SpecimenChoice& choice, const std::string& integrator) {
  Specimen specimen(config, choice.deformation, choice.cells, choice.ratio);
  Table rows = empty_rows();
  add_row(config, find_integrator(integrator), specimen, rows);
  return rows_of(rows);
}

std::vector<SpecimenChoice> specimens_of(const StabilityConfig& config) {
  std::vector<SpecimenChoice> all;
  for (const int n : config.cells)
    for (const double ratio : config.ratios) all.push_back({Deformation::none, n, ratio});
  for (const Deformation deformation : config.deformations)
    for (const double ratio : config.deformed_ratios)
      all.push_back({deformation, config.deformed_cells, ratio});
  return all;
}

}  // namespace

std::string_view to_string(Deformation deformation) {
  switch (deformation) {
    case Deformation::none:
      return "none";
    case Deformation::stretched:
      return "stretched";
    case Deformation::compressed:
      return "compressed";
    case Deformation::bent:
      break;
  }
  return "bent";
}

Specimen::Specimen(const StabilityConfig& config, Deformation how, int n, double damping)
    : deformation(how),
      cells(n),
      ratio(damping),
      body(body_of(config, how, n, damping)),
      system(body, clamps(how), {.threads = 1}),
      equilibrium(system.rest_state()) {
  if (how != Deformation::none) {
    Equilibrium found = find_equilibrium(system, [&](const Vec3& rest) { return roughly(how, rest); });
    equilibrium = std::move(found.state);
    status = found.status;
  }
  if (status != Status::ok) return;
  Work work;
  const Modes fastest = fastest_mode(system, equilibrium, work);
  status = fastest.status;
  if (status == Status::ok) omega = fastest.modes.front().omega;
}

MeasuredStep measure_step(const StabilityConfig& config, const IntegratorInfo& method, Specimen& specimen) {
  constexpr double share = 1e-2, smallest = 1e-3, largest = 1e4;  // of the time through a cell
  const double through_cell = specimen.body.config().cell_size * std::sqrt(config.density / config.young);
  double low = share * through_cell;
  while (!is_stable(config, method, specimen, low)) {
    low /= 4;
    if (low < smallest * through_cell) return {};
  }
  double high = 4 * low;
  while (is_stable(config, method, specimen, high)) {
    low = high;
    high *= 4;
    if (high > largest * through_cell) return {low, infinity};
  }
  while (high - low > config.resolution * low) {
    const double middle = (low + high) / 2;
    (is_stable(config, method, specimen, middle) ? low : high) = middle;
  }
  return {low, high};
}

StabilityTables measure_stability(const StabilityConfig& config, int processes, Journal& journal,
                                  Progress& progress) {
  std::vector<Case> cases;
  for (const SpecimenChoice& choice : specimens_of(config))
    for (const std::string& integrator : config.integrators)
      cases.push_back({fmt::format("{}, {}", integrator, choice.name()),
                       [&config, choice, &integrator] { return compute_row(config, choice, integrator); }});
  for (Case& one : cases) one.group = one.name;
  StabilityTables tables{empty_rows()};
  tables.status = gather_cases(cases, processes, journal, progress,
                               [&](const Json& rows) { add_rows(rows, tables.rows); });
  return tables;
}

}  // namespace mss::studies::stability
