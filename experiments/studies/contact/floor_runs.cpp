// A body on the floor: the single runs.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include "core/base/error.hpp"
#include "core/measures/measures.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/simulation/equilibrium.hpp"
#include "experiments/simulation/outcome.hpp"
#include "experiments/studies/contact/floor.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::contact {

namespace {

constexpr double sample = 1.0 / 240;                        // between samples, where steps are not longer [s]
constexpr long costed_steps = 500;                          // the first ones, of which costs are means
constexpr double deepest_allowed = 1e-12, touching = 1e-6;  // [m]
constexpr double hopeless = 100;                            // times the initial energy

/// Planes are the coordinate planes, gravity is inclined.
Environment environment_of(const FloorScene& scene) {
  const double angle = scene.degrees * std::numbers::pi / 180;
  const bool groove = scene.task == FloorTask::groove;
  Environment environment{
      .gravity = gravity * Vec3(groove ? -std::sin(angle) : std::sin(angle), 0, -std::cos(angle)),
      .planes = {{.normal = Vec3::UnitZ(), .friction = scene.friction}}};
  if (groove) environment.planes.push_back({.normal = Vec3::UnitX(), .friction = scene.friction});
  return environment;
}

/// Heights at rest of the lowest and the highest particles [m].
struct Layers {
  explicit Layers(const Body& body) {
    for (const std::ptrdiff_t site : body.sites()) {
      bottom = std::min(bottom, body.rest_position(site)[2]);
      top = std::max(top, body.rest_position(site)[2]);
    }
  }
  static Box box(double height) { return {{-1, -1, height - 1e-9}, {1, 1, height + 1e-9}}; }
  double bottom = std::numeric_limits<double>::infinity(), top = -bottom;
};

BodyConfig loaded(BodyConfig config, double burden) {
  if (burden == 0) return config;
  const Body body(config);
  config.weights = {{.box = Layers::box(Layers(body).top), .mass = burden * body.total_mass()}};
  return config;
}

/// Mean position of the particles that are at a height at rest [m].
Vec3 mean_at(double height, const Body& body, const Field<double>& x) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const std::ptrdiff_t site : body.sites())
    if (std::abs(body.rest_position(site)[2] - height) < 1e-9) sum += x.at(site), ++count;
  return sum / count;
}

/// The bottom stays at its height and slides without friction.
std::vector<Hold> bottom_at_its_height(const Body& body) {
  const Layers layers(body);
  std::vector<Hold> holds{{.box = Layers::box(layers.bottom), .axes = {false, false, true}}};
  const auto hold = [&](const std::ptrdiff_t site, std::array<bool, 3> axes) {
    const Vec3 x = body.rest_position(site), little = Vec3::Constant(1e-9);
    holds.push_back({.box = {x - little, x + little}, .axes = axes});
  };
  const auto& sites = body.sites();  // the lowest first, of these those of the least y, then of the least x
  const double y = body.rest_position(sites.front())[1];
  const auto last = std::find_if(sites.begin(), sites.end(), [&](std::ptrdiff_t site) {
    return body.rest_position(site)[1] > y || body.rest_position(site)[2] > layers.bottom;
  });
  hold(sites.front(), {true, true, true});
  hold(*std::prev(last), {false, true, true});
  return holds;
}

/// Where the body is at rest so.
Equilibrium static_answer(const Body& body) {
  const Environment held{.gravity = {0, 0, -gravity}, .holds = bottom_at_its_height(body)};
  SpringSystem<double> system(body, held, {.threads = 1});
  return find_equilibrium(system, [](const Vec3& x) { return x; });
}

/// What the first steps of a run cost.
struct Cost {
  Work work{};
  double seconds = 0;  ///< of the processor, which other programs do not disturb
  double per_step(std::int64_t count) const { return double(count) / double(work.steps); }
  double seconds_per_step() const { return seconds / double(work.steps); }
};

double step_of(const FloorRun& run, const SpectralBound& bound) {
  if (run.step.dt > 0) return run.step.dt;
  const IntegratorInfo& method = find_integrator(run.integrator);
  return safe_share * stable_step(method.limit ? method : find_integrator("semi_implicit_euler"), bound);
}

/// A body moved by a method.
class MovedBody {
 public:
  MovedBody(const Body& body, const Environment& environment, const std::string& integrator, double dt)
      : system_(body, environment, {.threads = 1}),
        state_(system_.rest_state()),
        info_(find_integrator(integrator)),
        dt_(dt),
        method_(info_.make<double>({.dt = dt})) {}

  void move(const Vec3& by) {
    for (const std::ptrdiff_t site : system_.particles()) state_.x.set(site, state_.x.at(site) + by);
  }
  void place(const Field<double>& x) {
    for (const std::ptrdiff_t site : system_.particles()) state_.x.set(site, x.at(site));
  }
  Status advance(double t) {
    const std::clock_t begin = std::clock();
    const Status status = method_->advance(system_, state_, t, work_);
    seconds_ += double(std::clock() - begin) / CLOCKS_PER_SEC;
    if (work_.steps <= costed_steps || cost_.work.steps == 0) cost_ = {work_, seconds_};
    return status;
  }
  Measures measured() { return measure_in_time(system_, state_, velocity_lag(info_, dt_)); }
  /// Kinetic energy, that of gravity, and what springs store, which methods of no material do not know [J].
  double energy_of(const Measures& m) const {
    return info_.has_modulus ? m.total() : m.kinetic + m.external_potential;
  }
  const State<double>& state() const { return state_; }
  const Cost& cost() const { return cost_; }
  const std::vector<Plane>& planes() const { return system_.environment().planes; }
  /// Of the particle nearest to a plane or deepest behind it [m].
  double gap(const Plane& plane) const {
    double least = std::numeric_limits<double>::infinity();
    for (const std::ptrdiff_t site : system_.particles())
      least = std::min(least, plane.gap(state_.x.at(site)));
    return least;
  }

 private:
  SpringSystem<double> system_;
  State<double> state_;
  const IntegratorInfo& info_;
  double dt_;
  std::unique_ptr<Integrator<double>> method_;
  Work work_;
  double seconds_ = 0;
  Cost cost_;
};

/// What is known of a moment.
struct Sample {
  double t;
  double top;             ///< mean height [m]
  Vec3 bottom, velocity;  ///< mean position of the lowest particles; of the centre of mass
};

/// What a run is judged by.
struct Course {
  std::vector<Sample> samples{};
  double energy = 1;       ///< largest over initial, above the planes: see height_of_energy()
  double penetration = 0;  ///< deepest [m]
  bool touched = false;    ///< every plane at once, in the second half
  Status status = Status::ok;
};

/// From where the body falls [m]; else of its centre of mass above its lowest particle, along gravity.
double height_of_energy(const FloorScene& scene, const Body& body, const Vec3& pull) {
  if (scene.task == FloorTask::drop) return scene.height;
  const Vec3 up = -pull.normalized();
  double centre = 0, lowest = std::numeric_limits<double>::infinity();
  for (const std::ptrdiff_t site : body.sites()) {
    const double height = up.dot(body.rest_position(site));
    centre += height * body.mass(site) / body.total_mass();
    lowest = std::min(lowest, height);
  }
  return centre - lowest;
}

bool sags(const FloorRun& run) {
  return run.scene.task == FloorTask::rest || run.scene.task == FloorTask::loaded;
}

/// At 60 steps a second bodies have the scene's time. Shorter steps would take too long for that: there what
/// sags begins in the static answer, and times are those in which a body of that stiffness comes to rest.
bool has_time(const FloorRun& run) { return run.step.dt == floor_steps().front().dt; }

/// Simulated time [s].
double seconds_of(const FloorRun& run) {
  if (has_time(run)) return run.scene.seconds;
  if (run.scene.task == FloorTask::slide || run.scene.task == FloorTask::drop) return 0.6;
  return run.young < 5e5 ? 2 : run.young < 5e6 ? 0.8 : 0.4;
}

/// From sample to sample, as whole steps allow, to the end; or until energy shows that nothing is to be
/// expected.
Course follow(const FloorRun& run, const Body& body, double dt, MovedBody& moved) {
  const Layers layers(body);
  const Environment environment = environment_of(run.scene);
  const double seconds = seconds_of(run), start = moved.energy_of(moved.measured()),
               reference =
                   body.total_mass() * gravity * height_of_energy(run.scene, body, environment.gravity);
  const long stride = std::max(1L, std::lround(sample / dt)), steps = std::lround(seconds / dt);
  Course course;
  const auto record = [&](const Measures& m) {
    const Field<double>& x = moved.state().x;
    course.samples.push_back({moved.state().t, mean_at(layers.top, body, x)[2],
                              mean_at(layers.bottom, body, x), m.momentum / body.total_mass()});
    course.energy = std::max(course.energy, 1 + (moved.energy_of(m) - start) / reference);
    bool all = true;
    for (const Plane& plane : moved.planes()) {
      const double gap = moved.gap(plane);
      course.penetration = std::max(course.penetration, -gap);
      all = all && gap < touching;
    }
    course.touched = course.touched || (all && moved.state().t > seconds / 2);
  };
  record(moved.measured());
  for (long step = stride; step <= steps && course.energy < hopeless; step += stride) {
    course.status = moved.advance(double(step) * dt);
    if (course.status != Status::ok) break;
    const Measures m = moved.measured();
    if (!std::isfinite(m.total())) course.status = Status::non_finite;
    if (course.status != Status::ok) break;
    record(m);
  }
  return course;
}

/// The sample nearest to a share of the time.
const Sample& at_share(const Course& course, double share) {
  const double t = share * course.samples.back().t;
  return *std::min_element(
      course.samples.begin(), course.samples.end(),
      [t](const Sample& a, const Sample& b) { return std::abs(a.t - t) < std::abs(b.t - t); });
}

/// Of the mean over the second half: methods that keep what their steps do not resolve swing for long.
/// Moments count most in its middle, so that it hardly matters how many swings it has.
double sag_error(const Course& course, const Body& body, const Field<double>& at_rest) {
  const Layers layers(body);
  double sum = 0, weights = 0;
  for (const Sample& s : course.samples) {
    const double share = std::max(0.0, 2 * s.t / course.samples.back().t - 1),
                 weight = 1 - std::cos(2 * std::numbers::pi * share);
    sum += weight * (layers.top - s.top);
    weights += weight;
  }
  return std::abs(sum / weights / (layers.top - mean_at(layers.top, body, at_rest)[2]) - 1);
}

/// Of the bottom in the last fifth, as if it went on for 1.5 s.
double creep(const Course& course) {
  const Sample &before = at_share(course, 0.8), &end = course.samples.back();
  return (end.bottom - before.bottom).norm() * 1.5 / (end.t - before.t);
}

/// From a third of the time on. Friction is mu times what stops the body along the normal, too.
double acceleration_error(const Course& course, const FloorScene& scene) {
  const Sample &before = at_share(course, 1.0 / 3), &end = course.samples.back();
  const double angle = scene.degrees * std::numbers::pi / 180,
               expected = gravity * (std::sin(angle) - scene.friction * std::cos(angle));
  const Vec3 gained = end.velocity - before.velocity;
  return std::abs((gained[0] + scene.friction * gained[2]) / (end.t - before.t) / expected - 1);
}

/// `at_rest` [m]: of what sags.
double error_of(const FloorRun& run, const Course& course, const Body& body, const Field<double>& at_rest) {
  switch (run.scene.task) {
    case FloorTask::rest:
    case FloorTask::loaded:
      return sag_error(course, body, at_rest);
    case FloorTask::stick:
    case FloorTask::groove:
      return creep(course);
    case FloorTask::slide:
      return acceleration_error(course, run.scene);
    case FloorTask::drop:
      return course.energy - 1;
  }
  return no_value;
}

/// The largest error that a method may have; those that go through springs or particles one by one have
/// wider ones.
double bound_of(const FloorRun& run) {
  const bool one_by_one = find_integrator(run.integrator).springs_only;
  switch (run.scene.task) {
    case FloorTask::rest:
    case FloorTask::loaded:
      return family_of(run.integrator) == "xpbd" ? 0.05 : 0.01;
    case FloorTask::stick:
      return one_by_one ? 5e-4 : 1e-5;
    case FloorTask::slide:
      return one_by_one ? 0.01 : 0.002;
    case FloorTask::drop:
      return 1e-3;
    case FloorTask::groove:
      return one_by_one ? 5e-4 : 1e-4;
  }
  return no_value;
}

std::string judge(const FloorRun& run, const Course& course, double error) {
  const double bound = bound_of(run);
  if (course.status != Status::ok) return std::string(to_string(course.status));
  if (course.energy > 1 + (run.scene.task == FloorTask::drop ? bound : SampledRun::tolerated_growth))
    return "gains_energy";
  if (course.penetration > deepest_allowed) return "penetrates";
  if (!course.touched) return "never_touched";
  return error <= bound ? "ok" : "off";
}

/// Where the run begins: undeformed or, with shorter steps than 1/60 s, in the static answer.
void begin(const FloorRun& run, const Equilibrium& answer, MovedBody& moved) {
  if (sags(run) && !has_time(run)) moved.place(answer.state.x);
  for (const Plane& plane : environment_of(run.scene).planes) moved.move(run.scene.height * plane.normal);
}

/// What holds do in place of planes: what falls is free.
std::vector<Hold> holds_of(const FloorRun& run, const Body& body) {
  if (run.scene.task == FloorTask::drop) return {};
  if (sags(run)) return bottom_at_its_height(body);
  return {{.box = Layers::box(Layers(body).bottom)}};
}

Cost cost_without_contact(const FloorRun& run, const Body& body, double dt, const Equilibrium& answer) {
  Environment environment = environment_of(run.scene);
  environment.planes.clear();
  environment.holds = holds_of(run, body);
  MovedBody moved(body, environment, run.integrator, dt);
  if (run.scene.task != FloorTask::groove) begin(run, answer, moved);
  const long steps = std::min(costed_steps, std::lround(seconds_of(run) / dt)),
             stride = std::max(1L, std::lround(sample / dt));
  for (long step = stride; step <= steps; step += stride)
    if (moved.advance(double(step) * dt) != Status::ok) break;
  return moved.cost();
}

/// What the columns from `dt` to `cost` show.
struct Numbers {
  double dt = no_value, error = no_value, energy = no_value, penetration = no_value;
  double solves = no_value, evaluations = no_value, free_solves = no_value, free_evaluations = no_value,
         cost = no_value;
};

void add(const FloorRun& run, const Numbers& n, const std::string& status, const std::string& reason,
         Table& rows) {
  const FloorScene& scene = run.scene;
  rows.add({run.shape, scene.name, run.integrator, run.young, run.step.name, n.dt,
            scene.quantity + (scene.unit.empty() ? "" : " [" + scene.unit + "]"), n.error, bound_of(run),
            n.energy, n.penetration, n.solves, n.evaluations, n.free_solves, n.free_evaluations, n.cost,
            status, reason});
}

void compute(const FloorRun& run, Table& rows) {
  const Body body(loaded(floor_body(run.shape, run.young), run.scene.burden));
  const Environment environment = environment_of(run.scene);
  Numbers n{.dt = step_of(run, SpringSystem<double>(body, environment, {.threads = 1}).spectral_bound())};
  MovedBody moved(body, environment, run.integrator, n.dt);
  const Equilibrium answer = sags(run) ? static_answer(body) : Equilibrium{};
  if (answer.status != Status::ok) return add(run, n, "not_compared", "no static answer", rows);
  begin(run, answer, moved);
  const Course course = follow(run, body, n.dt, moved);
  const Cost cost = moved.cost(), free = cost_without_contact(run, body, n.dt, answer);
  n.energy = course.energy;
  n.penetration = course.penetration;
  n.solves = cost.per_step(cost.work.linear_solves);
  n.evaluations = cost.per_step(cost.work.force_evaluations);
  n.free_solves = free.per_step(free.work.linear_solves);
  n.free_evaluations = free.per_step(free.work.force_evaluations);
  n.cost = cost.seconds_per_step() / free.seconds_per_step();
  if (course.status == Status::ok && course.energy < hopeless)
    n.error = error_of(run, course, body, answer.state.x);
  if (free.work.steps == 0) return add(run, n, "not_compared", "its first step fails without contact", rows);
  add(run, n, judge(run, course, n.error), "", rows);
}

}  // namespace

Table empty_floor() {
  return Table({{"shape"},
                {"scene"},
                {"integrator"},
                {"young", "Pa"},
                {"step"},
                {"dt", "s"},
                {"quantity"},
                {"error"},
                {"bound"},
                {"energy"},
                {"penetration", "m"},
                {"solves"},
                {"evaluations"},
                {"free_solves"},
                {"free_evaluations"},
                {"cost"},
                {"status"},
                {"reason"}});
}

void add_floor_run(const FloorRun& run, Table& rows) {
  try {
    compute(run, rows);
  } catch (const InputError& error) {
    add(run, {}, "refused", error.what(), rows);
  }
}

}  // namespace mss::studies::contact
