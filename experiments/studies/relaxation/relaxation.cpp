// A bar of springs that relax in axial load, beside the closed forms of a standard linear solid: the complex
// modulus against frequency, and creep in time. Charts are in chart.cpp.
#include "experiments/studies/relaxation/relaxation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/springs/spring_system.hpp"
#include "integrators/integrator.hpp"

namespace mss::studies::relaxation {

namespace {

constexpr double small = 1e-8;  ///< strains, so small that the bar is linear
constexpr double nu = 0.25;

/// Nothing in it swings: its density is as good as none.
BodyConfig bar(const RelaxationConfig& config) {
  BodyConfig body{
      .voxels = VoxelGrid::box(config.cells, 1, 1), .cell_size = config.cell_size, .density = 1e-6};
  body.fill({.young = config.young, .poisson = nu}, 0.5);
  body.springs.volume = 0;  // but for rounding it is
  body.relaxation = config.relaxation;
  return body;
}

/// Force at its lower end [N].
double pull(SpringSystem<double>& system, const State<double>& state) {
  Field<double> force(system.size());
  system.force(state.t, state.x, state.v, force);
  double sum = 0;
  for (const std::ptrdiff_t site : system.particles())
    if (system.rest_position(site)[0] < small) sum += force.axis(0)[site];
  return sum;
}

/// Uniform strain along it, and nu times that across.
void strain_to(const SpringSystem<double>& system, double strain, State<double>& state) {
  for (const std::ptrdiff_t site : system.particles()) {
    const Vec3 rest = system.rest_position(site);
    state.x.set(site, Vec3(rest[0] * (1 + strain), rest[1] * (1 - nu * strain), rest[2] * (1 - nu * strain)));
  }
}

/// By Fourier's coefficient of the force in the last of the periods that it takes to settle.
std::complex<double> measured_modulus(const RelaxationConfig& config, double frequency, int steps) {
  const double omega = frequency / config.relaxation.time, period = 2 * std::numbers::pi / omega;
  const Body body(bar(config));
  SpringSystem<double> system(body, {}, {.threads = 1});
  State<double> state = system.undeformed_state();
  strain_to(system, small, state);
  const double at_rest = pull(system, state);
  const int periods = 3 + int(20 * config.relaxation.time / period);
  std::complex<double> sum = 0;
  for (int n = 0; n <= periods * steps; ++n) {
    state.t = n * period / steps;
    strain_to(system, small * std::sin(omega * state.t), state);
    system.memory()->come_to(state);
    if (n > (periods - 1) * steps) sum += pull(system, state) * std::polar(1.0, -omega * state.t);
  }
  return sum * std::complex<double>(0, 2.0 / steps) / at_rest;
}

Table empty_modulus() {
  return Table({{"frequency"},
                {"steps_per_period"},
                {"storage"},
                {"storage_exact"},
                {"loss"},
                {"loss_exact"},
                {"error"},
                {"status"}});
}

void add_modulus(const RelaxationConfig& config, double frequency, Table& rows) {
  const std::complex<double> exact = complex_modulus(config.relaxation, frequency);
  for (const int steps : config.steps) {
    const std::complex<double> measured = measured_modulus(config, frequency, steps);
    rows.add({frequency, std::int64_t(steps), measured.real(), exact.real(), measured.imag(), exact.imag(),
              std::abs(measured - exact), std::string("ok")});
  }
}

constexpr double grown = 0.25;  ///< of the relaxation time: until then the load grows

Environment loaded(const RelaxationConfig& config, bool in_time) {
  Environment environment;
  const double length = config.cells * config.cell_size, far = 2 * length;
  for (int axis = 0; axis < 3; ++axis) {  // free to contract
    Hold hold{.box = {Vec3::Constant(-far), Vec3::Constant(far)}, .axes = {axis == 0, axis == 1, axis == 2}};
    hold.box.upper[axis] = small;
    environment.holds.push_back(hold);
  }
  const double force = small * config.young * config.cell_size * config.cell_size;
  environment.loads.push_back({{Vec3(length - small, -far, -far), Vec3::Constant(far)}, Vec3(force, 0, 0)});
  if (in_time) environment.loads.back().history = {{{0, 0}, {grown * config.relaxation.time, 1}}};
  return environment;
}

double end_moved(const SpringSystem<double>& system, const RelaxationConfig& config,
                 const State<double>& state) {
  double sum = 0;
  int count = 0;
  for (const std::ptrdiff_t site : system.particles())
    if (const Vec3 rest = system.rest_position(site); rest[0] > config.cells * config.cell_size - small) {
      sum += state.x.at(site)[0] - rest[0];
      ++count;
    }
  return sum / count;
}

Table empty_creep() {
  return Table({{"integrator"}, {"step"}, {"time"}, {"strain"}, {"strain_exact"}, {"error"}, {"status"}});
}

/// Times and steps over the relaxation time, strains over that at rest.
void add_creep(const RelaxationConfig& config, const std::string& name, double step, Table& rows) {
  const Body body(bar(config));
  Work work;
  SpringSystem<double> resting(body, loaded(config, false), {.threads = 1});
  State<double> at_rest = resting.rest_state();
  const Status found = find_integrator("static").make<double>({})->advance(resting, at_rest, 1, work);
  const double finally = end_moved(resting, config, at_rest), time = config.relaxation.time;
  SpringSystem<double> system(body, loaded(config, true), {.threads = 1});
  State<double> state = system.rest_state();
  const auto method = find_integrator(name).make<double>({.dt = step * time});
  for (const double t : {0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0}) {
    const Status status = found == Status::ok ? method->advance(system, state, t * time, work) : found;
    const double strain = end_moved(system, config, state) / finally,
                 exact = creep(config.relaxation, grown * time, t * time);
    rows.add({name, step, t, strain, exact, std::abs(strain - exact), std::string(to_string(status))});
    if (status != Status::ok) return;
  }
}

constexpr const char* caption =
    "A bar of 4 x 1 x 1 cells of springs that relax (material.relaxation), nu = 1/4 and no volume force, so "
    "that all "
    "of it relaxes alike; small strains. Modulus: uniform strains oscillate, and the force at an end is "
    "compared "
    "with E (1 + ratio i w time / (1 + i w time)); branches are exact for straight paths, so errors go with "
    "the "
    "square of the steps. Creep: a load along the bar grows for a quarter of the relaxation time and stays; "
    "the bar has next to no mass, so that nothing swings. Left out: bodies with volume force, which does not "
    "relax.";

Json configuration(const RelaxationConfig& c) {
  return {{"young", c.young},
          {"poisson", nu},
          {"cells", c.cells},
          {"ratio", c.relaxation.ratio},
          {"time", c.relaxation.time},
          {"frequencies", c.frequencies},
          {"steps", c.steps},
          {"methods", c.methods},
          {"creep_steps", c.creep_steps}};
}

/// The largest error of some rows.
double largest_error(const Table& rows) {
  double largest = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) largest = std::max(largest, rows.number(r, "error"));
  return largest;
}

std::string summary(const RelaxationTables& tables) {
  std::string lines;
  for (const double steps : tables.modulus.distinct_numbers("steps_per_period"))
    lines += fmt::format("complex modulus, {:>6} steps a period: error {:.1e} of the modulus at rest\n",
                         steps, largest_error(tables.modulus.where("steps_per_period", steps)));
  for (const std::string& name : tables.creep.distinct("integrator"))
    for (const double step : tables.creep.distinct_numbers("step"))
      lines += fmt::format("creep by {:<16} in steps of time / {:<6g}: error {:.1e} of the strain at rest\n",
                           name, std::round(1 / step),
                           largest_error(tables.creep.where("integrator", name).where("step", step)));
  return lines;
}

ExperimentResult run_relaxation(const ExperimentOptions& options, Progress& progress) {
  const RelaxationConfig config = relaxation_config(options);
  RelaxationTables tables = measure_relaxation(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables);
  result.tables = relaxation_files(std::move(tables));
  return result;
}

Table baseline_table(const BaselineOptions&, Progress& progress) {
  RelaxationTables tables = measure_relaxation(relaxation_config({.quick = true}), progress);
  Table rows({{"part"}, {"case"}, {"at"}, {"value"}, {"status"}});
  for (std::size_t r = 0; r < tables.modulus.size(); ++r)
    for (const char* part : {"storage", "loss"})
      rows.add({std::string(part), fmt::format("{} steps", tables.modulus.number(r, "steps_per_period")),
                tables.modulus.number(r, "frequency"), tables.modulus.number(r, part),
                tables.modulus.text(r, "status")});
  for (std::size_t r = 0; r < tables.creep.size(); ++r)
    rows.add({std::string("creep"),
              fmt::format("{} {:g}", tables.creep.text(r, "integrator"), tables.creep.number(r, "step")),
              tables.creep.number(r, "time"), tables.creep.number(r, "strain"),
              tables.creep.text(r, "status")});
  return rows;
}

}  // namespace

std::complex<double> complex_modulus(const Relaxation& relaxation, double frequency) {
  const std::complex<double> i(0, frequency);
  return 1.0 + relaxation.ratio * i / (1.0 + i);
}

double creep(const Relaxation& relaxation, double grown_in, double t) {
  const double late = (1 + relaxation.ratio) * relaxation.time,
               share = relaxation.ratio / (1 + relaxation.ratio);
  if (t < grown_in) return (t + share * late * std::expm1(-t / late)) / grown_in;
  return 1 - share * late / grown_in * std::expm1(grown_in / late) * std::exp(-t / late);
}

RelaxationConfig relaxation_config(const ExperimentOptions& options) {
  RelaxationConfig config;
  config.frequencies = {0.1, 0.3, 1, 3, 10};
  config.steps = {100, 1000};
  config.methods = {"backward_euler", "tr_bdf2"};
  config.creep_steps = {1.0 / 20, 1.0 / 200};
  if (options.quick) return config;
  config.frequencies = {0.03, 0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 10, 30};
  config.steps = {100, 1000, 10000};
  config.methods = {"backward_euler", "generalized_alpha", "tr_bdf2"};
  config.creep_steps = {1.0 / 20, 1.0 / 200, 1.0 / 2000};
  return config;
}

RelaxationTables measure_relaxation(const RelaxationConfig& config, Progress& progress) {
  RelaxationTables tables{empty_modulus(), empty_creep()};
  std::vector<std::function<void()>> parts;
  for (const double frequency : config.frequencies)
    parts.emplace_back([&, frequency] { add_modulus(config, frequency, tables.modulus); });
  for (const std::string& name : config.methods)
    for (const double step : config.creep_steps)
      parts.emplace_back([&, name, step] { add_creep(config, name, step, tables.creep); });
  for (std::size_t i = 0; i < parts.size(); ++i) {
    progress.report(double(i) / double(parts.size()), "a bar that relaxes");
    if (progress.stopped()) {
      tables.status = Status::interrupted;
      break;
    }
    parts[i]();
  }
  return tables;
}

std::vector<NamedTable> relaxation_files(RelaxationTables tables) {
  return {{"relaxation", std::move(tables.modulus)}, {"relaxation_creep", std::move(tables.creep)}};
}

ExperimentInfo experiment() {
  return {.name = "relaxation",
          .under = "validate",
          .summary = "a bar of springs that relax, beside closed forms of its complex modulus and its creep",
          .run = run_relaxation,
          .draw = draw_relaxation,
          .baseline = {.keys = {"part", "case", "at"}, .rules = {{"value", 1e-7}}, .table = baseline_table}};
}

}  // namespace mss::studies::relaxation
