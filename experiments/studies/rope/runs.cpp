// Ropes and sheets under tension, and ropes that hang, beside closed forms.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/springs/spring_system.hpp"
#include "experiments/studies/rope/rope.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "reference/closed_forms.hpp"

namespace mss::studies::rope {

namespace {

constexpr double turn = 2 * std::numbers::pi;

BodyConfig body_of(const RopeConfig& config, VoxelGrid cells) {
  BodyConfig body{.voxels = std::move(cells), .thickness = config.thickness, .density = config.density};
  body.cell_size = config.length / body.voxels.nx();
  body.fill(config.material, 0.5);
  return body;
}

/// Holds of the sides across x, and of a sheet of those across y, along `axes` and as they pull outwards.
std::vector<Hold> pulled_apart(const RopeConfig& config, int dimensions) {
  std::vector<Hold> holds;
  const double far = 2 * config.length;
  for (int axis = 0; axis < dimensions; ++axis)
    for (const int side : {0, 1}) {
      Hold hold{.box = {Vec3::Constant(-far), Vec3::Constant(far)}, .turn = {}};
      hold.box.lower[axis] = hold.box.upper[axis] = side * config.length;
      hold.axes = {axis == 0 || dimensions == 1, axis == 1 || dimensions == 1, true};
      hold.displacement[axis] = (side - 0.5) * config.strain * config.length;
      holds.push_back(hold);
    }
  return holds;
}

/// Uniformly stretched, as its holds have it: an equilibrium.
State<double> stretched(const SpringSystem<double>& system, const RopeConfig& config, int dimensions) {
  State<double> state = system.undeformed_state();
  for (const std::ptrdiff_t site : system.particles()) {
    Vec3 x = system.rest_position(site);
    for (int axis = 0; axis < dimensions; ++axis) x[axis] += (x[axis] - config.length / 2) * config.strain;
    state.x.set(site, x);
  }
  state.t = 1;
  return state;
}

/// Along the rope and across the section; of the sheet in all directions.
reference::Stretched tension_of(const RopeConfig& config, int dimensions) {
  const double stretch = 1 + config.strain, across = std::pow(config.thickness, 3 - dimensions),
               modulus = dimensions == 1 ? config.material.young
                                         : config.material.young / (1 - config.material.poisson);
  return {.length = stretch * config.length,
          .tension = modulus * config.strain * across / std::pow(stretch, dimensions - 1),
          .mass = config.density * across / std::pow(stretch, dimensions)};
}

/// Share of a motion's energy that is along an axis.
double share_along(const SpringSystem<double>& system, const Mode& mode, int axis) {
  double along = 0, all = 0;
  for (const std::ptrdiff_t site : system.particles()) {
    const Vec3 q = mode.shape.at(site);
    along += system.mass(site) * q[axis] * q[axis];
    all += system.mass(site) * q.squaredNorm();
  }
  return along / all;
}

/// Frequencies [Hz] of the slowest motions whose share along an axis is as a test says, ascending.
template <class Test>
std::vector<double> frequencies_of(const Modes& modes, const SpringSystem<double>& system, int axis,
                                   Test&& test) {
  std::vector<double> found;
  for (const Mode& mode : modes.modes)
    if (test(share_along(system, mode, axis))) found.push_back(mode.omega / turn);
  return found;
}

Table empty_waves() {
  return Table({{"body"},
                {"motion"},
                {"mode"},
                {"cells"},
                {"frequency", "Hz"},
                {"lattice", "Hz"},
                {"error_lattice"},
                {"continuum", "Hz"},
                {"error_continuum"},
                {"status"}});
}

double error_of(double value, double exact) { return std::abs(value / exact - 1); }

/// A frequency beside the closed forms of its lattice and of the continuum.
void add_wave(Table& rows, const char* body, const char* motion, const std::string& mode, int cells,
              double value, double lattice, double continuum, Status status) {
  rows.add({std::string(body), std::string(motion), mode, std::int64_t(cells), value, lattice,
            error_of(value, lattice), continuum, error_of(value, continuum), std::string(to_string(status))});
}

/// The chain of springs k and masses m that the rope is along itself: omega = 2 sqrt(k / m) sin(pi mode /
/// 2n).
void add_rope_modes(const RopeConfig& config, int links, Table& rows) {
  const Body body(body_of(config, VoxelGrid::box(links, 0, 0)));
  SpringSystem<double> system(body, {.holds = pulled_apart(config, 1)}, {.threads = 1});
  Work work;
  const int most = 3 * (links - 1);
  const Modes modes = slowest_modes(system, stretched(system, config, 1), std::min(most, 24), work);
  const reference::Stretched string = tension_of(config, 1);
  reference::Stretched bar = string;  // waves along it: dT/dlength in place of the tension
  bar.tension = config.material.young * config.thickness * config.thickness * (1 + config.strain);
  const std::vector<double> along =
      frequencies_of(modes, system, 0, [](double share) { return share > 0.5; });
  std::vector<double> across;  // each in two directions
  for (const double frequency : frequencies_of(modes, system, 0, [](double share) { return share < 0.5; }))
    if (across.empty() || frequency > (1 + 1e-6) * across.back()) across.push_back(frequency);
  const auto add = [&](const char* motion, const std::vector<double>& found, const reference::Stretched& of,
                       int mode) {
    if (int(found.size()) < mode) return;
    add_wave(rows, "rope", motion, std::to_string(mode), links, found[std::size_t(mode - 1)],
             reference::beaded_string_frequency(of, links, mode), reference::string_frequency(of, mode),
             modes.status);
  };
  for (const int mode : {1, 2, 3}) add("across", across, string, mode);
  add("along", along, bar, 1);
}

void add_sheet_modes(const RopeConfig& config, int squares, Table& rows) {
  const Body body(body_of(config, VoxelGrid::box(squares, squares, 0)));
  SpringSystem<double> system(body, {.holds = pulled_apart(config, 2)}, {.threads = 1});
  Work work;
  const Modes modes = slowest_modes(system, stretched(system, config, 2), 6, work);
  const reference::Stretched membrane = tension_of(config, 2);
  const std::vector<double> across =
      frequencies_of(modes, system, 2, [](double share) { return share > 0.5; });
  const std::array<std::array<int, 2>, 4> waves{{{1, 1}, {1, 2}, {2, 1}, {2, 2}}};
  for (std::size_t i = 0; i < std::min(waves.size(), across.size()); ++i) {
    const auto [p, q] = waves[i];
    if (i == 2) continue;  // as fast as the one before
    add_wave(rows, "sheet", "across", std::to_string(p) + "," + std::to_string(q), squares, across[i],
             reference::net_frequency(membrane, squares, p, q), reference::membrane_frequency(membrane, p, q),
             modes.status);
  }
}

/// Where a pulse across the rope is: the mean place of the squares of its heights.
double place_of_pulse(const SpringSystem<double>& system, const State<double>& state) {
  double sum = 0, weights = 0;
  for (const std::ptrdiff_t site : system.particles()) {
    const Vec3 x = state.x.at(site);
    sum += x[2] * x[2] * x[0];
    weights += x[2] * x[2];
  }
  return sum / weights;
}

Table empty_pulses() {
  return Table({{"links"}, {"speed", "m/s"}, {"speed_exact", "m/s"}, {"error"}, {"status"}});
}

/// A small pulse, as wide as an eighth of the rope, that runs a quarter of it, from 3/8. Left out where fewer
/// than two links are in its width.
void add_pulse(const RopeConfig& config, int links, Table& rows) {
  constexpr int widths = 8;
  if (links < 2 * widths) return;
  const Body body(body_of(config, VoxelGrid::box(links, 0, 0)));
  SpringSystem<double> system(body, {.holds = pulled_apart(config, 1)}, {.threads = 1});
  State<double> state = stretched(system, config, 1);
  state.t = 0;
  const reference::Stretched string = tension_of(config, 1);
  const double speed = reference::transverse_speed(string), width = string.length / widths,
               height = 1e-6 * config.length,
               from = -0.5 * config.strain * config.length + 0.375 * string.length;
  for (const std::ptrdiff_t site : system.particles()) {
    Vec3 x = state.x.at(site);
    const double u = (x[0] - from) / width, z = height * std::exp(-u * u);
    x[2] = z;
    state.x.set(site, x);
    state.v.set(site, Vec3(0, 0, speed * 2 * u / width * z));
  }
  system.constrain(0, state.x, state.v);
  const double before = place_of_pulse(system, state), seconds = 0.25 * string.length / speed;
  const IntegratorInfo& method = find_integrator("pefrl");
  const double enough = 0.25 * stable_step(method, system.spectral_bound());
  Work work;
  const Status status = method.make<double>({.dt = seconds / std::ceil(seconds / enough)})
                            ->advance(system, state, seconds, work);
  const double measured = (place_of_pulse(system, state) - before) / seconds;
  rows.add({std::int64_t(links), measured, speed, error_of(measured, speed), std::string(to_string(status))});
}

Table empty_catenaries() {
  return Table({{"links"},
                {"sag", "m"},
                {"sag_exact", "m"},
                {"error_sag"},
                {"pull", "N"},
                {"pull_exact", "N"},
                {"error_pull"},
                {"rise", "N"},
                {"rise_exact", "N"},
                {"error_rise"},
                {"status"}});
}

/// Nearly inextensible: its weight would stretch it by `stretch`. Sought from a parabola.
void add_catenary(const RopeConfig& config, int links, Table& rows) {
  constexpr double gravity = 9.81;
  const double area = config.thickness * config.thickness,
               weight = config.density * area * config.length * gravity;
  RopeConfig stiff = config;
  stiff.material.young = weight / area / config.stretch;
  const Body body(body_of(stiff, VoxelGrid::box(links, 0, 0)));
  const double inwards = (config.length - config.span) / 2;
  std::vector<Hold> holds;
  for (const int side : {0, 1}) {
    const Vec3 end(side * config.length, 0, 0);
    holds.push_back({.box = {end, end}, .displacement = Vec3((1 - 2 * side) * inwards, 0, 0), .turn = {}});
  }
  SpringSystem<double> system(body, {.gravity = {0, 0, -gravity}, .holds = holds}, {.threads = 1});
  const reference::Catenary exact = reference::catenary(config.length, config.span, config.stretch);
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : system.particles()) {
    const double along = system.rest_position(site)[0] / config.length, u = 2 * along - 1;
    state.x.set(site, Vec3(inwards + config.span * along, 0, -exact.sag * (1 - u * u)));
  }
  Work work;
  const Status status = find_integrator("static")
                            .make<double>({.tangent = Tangent::projected})
                            ->advance(system, state, 1, work);
  Field<double> force(system.size());
  system.force(state.t, state.x, state.v, force);
  const Vec3 on_end = -force.at(body.sites().front());
  const double sag = -state.x.at(body.sites()[std::size_t(links / 2)])[2];
  rows.add({std::int64_t(links), sag, exact.sag, error_of(sag, exact.sag), -on_end[0], weight * exact.pull,
            error_of(-on_end[0], weight * exact.pull), on_end[2], weight * exact.rise,
            error_of(on_end[2], weight * exact.rise), std::string(to_string(status))});
}

}  // namespace

RopeConfig rope_config(const ExperimentOptions& options) {
  RopeConfig config;
  config.links = {8, 16, 32, 64};
  config.squares = {4, 8, 16};
  if (options.quick) return config;
  config.links = {8, 16, 32, 64, 128};
  config.squares = {4, 8, 16, 32, 64};
  return config;
}

RopeTables measure_ropes(const RopeConfig& config, Progress& progress) {
  RopeTables tables{empty_waves(), empty_pulses(), empty_catenaries()};
  std::vector<std::function<void()>> parts;
  for (const int links : config.links) {
    parts.emplace_back([&, links] { add_rope_modes(config, links, tables.waves); });
    parts.emplace_back([&, links] { add_pulse(config, links, tables.pulses); });
    parts.emplace_back([&, links] { add_catenary(config, links, tables.catenaries); });
  }
  for (const int squares : config.squares)
    parts.emplace_back([&, squares] { add_sheet_modes(config, squares, tables.waves); });
  for (std::size_t i = 0; i < parts.size(); ++i) {
    progress.report(double(i) / double(parts.size()), "ropes and sheets");
    if (progress.stopped()) {
      tables.status = Status::interrupted;
      break;
    }
    parts[i]();
  }
  return tables;
}

}  // namespace mss::studies::rope
