// The runs of `mss validate contact`.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include "core/measures/measures.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/harness/case_rows.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/contact/contact.hpp"
#include "reference/closed_forms.hpp"

namespace mss::studies::contact {

namespace {

constexpr double longest_step = 1e-3;  ///< [s]; half the limit of central differences if that is shorter
const double slope = std::atan(0.5);

/// A method, a law and a body.
struct Subject {
  std::string integrator;
  ContactLaw law = ContactLaw::impulse;
  BodyKind body = BodyKind::particle;
  BodyConfig config{};
};

/// A body on the ground z = 0, moved by a method, under gravity that is inclined by an angle along x.
class Trial {
 public:
  Trial(const Subject& subject, double restitution, double friction, double angle = 0)
      : body_(subject.config),
        system_(body_,
                {.gravity = gravity * Vec3(std::sin(angle), 0, -std::cos(angle)),
                 .planes = {{.contact = subject.law, .restitution = restitution, .friction = friction}}},
                {.threads = 1}),
        state_(system_.rest_state()) {
    const IntegratorInfo& info = find_integrator(subject.integrator);
    const SpectralBound bound = system_.spectral_bound();
    IntegratorOptions options{.dt = 0};
    if (info.stepping == Stepping::fixed)
      options.dt = std::min(longest_step, 0.5 * central_limit(bound.omega, bound.damping));
    scale_errors(options, system_);
    dt_ = options.dt;
    method_ = info.make<double>(options);
  }

  bool advance(double t) {
    if (status_ == Status::ok) status_ = method_->advance(system_, state_, t, work_);
    return status_ == Status::ok;
  }
  /// Starts from the end of another one.
  void begin(const Trial& settled) {
    state_ = settled.state_;
    state_.t = 0;
    status_ = settled.status_;
  }
  void fail(Status status) { status_ = status; }
  void move(const Vec3& by) {
    for (const std::ptrdiff_t site : body_.sites()) state_.x.set(site, state_.x.at(site) + by);
  }
  void put_on_ground() {
    for (const std::ptrdiff_t site : body_.sites()) {
      const Vec3 x = state_.x.at(site);
      state_.x.set(site, {x[0], x[1], 0});
    }
  }
  void push(const Vec3& velocity, const Vec3& spin = Vec3::Zero()) {
    const Vec3 middle = centre();
    for (const std::ptrdiff_t site : body_.sites())
      state_.v.set(site, velocity + spin.cross(state_.x.at(site) - middle));
  }

  Status status() const { return status_; }
  double dt() const { return dt_; }
  double cell_size() const { return body_.config().cell_size; }
  Measures measured() const { return measure(system_, state_); }
  Vec3 velocity() const { return measured().momentum / body_.total_mass(); }
  Vec3 centre() const {
    Vec3 sum = Vec3::Zero();
    for (const std::ptrdiff_t site : body_.sites())
      sum += body_.mass(site) / body_.total_mass() * state_.x.at(site);
    return sum;
  }
  double lowest() const {
    double low = std::numeric_limits<double>::infinity();
    for (const std::ptrdiff_t site : body_.sites()) low = std::min(low, state_.x.at(site)[2]);
    return low;
  }

 private:
  Body body_;
  SpringSystem<double> system_;
  State<double> state_;
  std::unique_ptr<Integrator<double>> method_;
  Work work_;
  Status status_ = Status::ok;
  double dt_ = 0;
};

/// A measured value beside that of the law. A coefficient is compared by what follows from it: `error` is
/// that of the heights or the distance, relative.
struct Comparison {
  double value = no_value, expected = no_value;
  double error = no_value;
};

class Recorder {
 public:
  explicit Recorder(Table& rows) : rows_(rows) {}
  void add(Study study, const Subject& subject, double coefficient, double degrees, const Trial& trial,
           const Comparison& comparison) {
    const bool ok = trial.status() == Status::ok;
    const bool found = std::isfinite(comparison.value) && std::isfinite(comparison.error);
    rows_.add({std::string(to_string(study)), to_string(subject.law), subject.integrator,
               std::string(to_string(subject.body)), coefficient, degrees, trial.dt(),
               ok && found ? comparison.value : no_value, comparison.expected,
               ok && found ? comparison.error : no_value,
               std::string(ok && !found ? "not found" : to_string(trial.status()))});
  }

 private:
  Table& rows_;
};

/// Heights of the first bounces of a particle dropped from 1 m; fewer if the time is over before.
std::vector<double> heights(Trial& trial, int bounces, double seconds) {
  std::vector<double> tops;
  trial.put_on_ground();
  trial.move({0, 0, 1});
  double before = 1, highest = 0;
  bool rising = false;
  for (long i = 1; double(i) * longest_step < seconds && trial.advance(double(i) * longest_step); ++i) {
    const double height = trial.centre()[2];
    highest = rising ? std::max(highest, height) : height;
    if (rising && height < before) tops.push_back(highest);
    if (int(tops.size()) == bounces) break;
    rising = height > before;
    before = height;
  }
  return tops;
}

void bounce(const Subject& subject, double restitution, Recorder& recorder) {
  constexpr double lowest = 0.01;  // [m]; the spacing of samples does not resolve lower bounces
  int bounces = 1;
  while (bounces < 4 && reference::bounce_height(1, restitution, bounces + 1) >= lowest) ++bounces;
  Trial trial(subject, restitution, 0.4);
  const double fall = std::sqrt(2 / gravity);
  const std::vector<double> tops = heights(trial, bounces, fall * (2 + 2 * bounces));
  Comparison comparison{.expected = restitution};
  if (restitution == 0) {  // it should stay on the ground
    comparison.error = tops.empty() ? 0 : std::max(0.0, tops.front());
    comparison.value = std::sqrt(comparison.error);
  } else if (int(tops.size()) == bounces) {
    comparison.value = std::pow(tops.back(), 0.5 / bounces);
    comparison.error = 0;
    for (int k = 1; k <= bounces; ++k)
      comparison.error =
          std::max(comparison.error,
                   std::abs(tops[std::size_t(k - 1)] / reference::bounce_height(1, restitution, k) - 1));
  }
  recorder.add(Study::bounce, subject, restitution, 0, trial, comparison);
}

/// The coefficient of friction that would stop a push after the distance of the run.
void stop(const Subject& subject, double friction, double degrees, Recorder& recorder) {
  constexpr double speed = 2;
  const double angle = degrees * std::numbers::pi / 180;
  Trial trial(subject, 0.5, friction);
  if (subject.body == BodyKind::particle) trial.put_on_ground();
  trial.push(speed * Vec3(std::cos(angle), std::sin(angle), 0));
  const Vec3 start = trial.centre();
  trial.advance(1.5 * speed / (friction * gravity));
  Vec3 moved = trial.centre() - start;
  moved[2] = 0;
  const double expected = reference::stopping_distance(gravity, speed, friction);
  recorder.add(Study::stop, subject, friction, degrees, trial,
               {.value = speed * speed / (2 * gravity * moved.norm()),
                .expected = friction,
                .error = std::abs(moved.norm() / expected - 1)});
}

/// How far a body slides in a second. A block first settles on the slope under high friction, and slides for
/// some time before the second begins, because the strain of sticking is released suddenly.
void slide(const Subject& subject, double friction, Recorder& recorder) {
  constexpr double settling = 0.6, high_friction = 10, one_second = 1;
  const double run_in = subject.body == BodyKind::particle ? 0 : 0.4;
  Trial trial(subject, 0, friction, slope);
  if (subject.body == BodyKind::particle) {
    trial.put_on_ground();
  } else {
    Trial settled(subject, 0, high_friction, slope);
    settled.advance(settling);
    trial.begin(settled);
    trial.advance(run_in);
  }
  const Vec3 start = trial.centre(), velocity = trial.velocity();
  trial.advance(run_in + one_second);
  const double value = (trial.centre() - start)[0] - velocity[0] * one_second;
  const double expected = expected_slide(friction), frictionless = expected_slide(0);
  recorder.add(Study::slope, subject, friction, 0, trial,
               {.value = value,
                .expected = expected,
                .error = std::abs(value - expected) / (expected > 0 ? expected : frictionless)});
}

/// Measurements of a cube that is dropped spinning.
struct Landing {
  double peak = 0;     ///< of its kinetic energy [J]
  double deepest = 0;  ///< below the ground [m]
  double rise = 0;     ///< largest gain of energy between samples that cannot have had contact [J]
  std::vector<double> t, kinetic;
};

Landing land(Trial& trial, double seconds) {
  constexpr double sample = 0.01;                     // [s]
  const double out_of_reach = trial.cell_size() / 4;  // no contact since the last sample
  Landing landing;
  double before = no_value;
  trial.push({1, 0, 0}, {3, 2, 1});
  for (long i = 1; double(i) * sample <= seconds && trial.advance(double(i) * sample); ++i) {
    const Measures m = trial.measured();
    if (!is_finite(m)) {  // energies overflow before coordinates do
      trial.fail(Status::non_finite);
      break;
    }
    const double low = trial.lowest();
    landing.t.push_back(m.t);
    landing.kinetic.push_back(m.kinetic);
    landing.peak = std::max(landing.peak, m.kinetic);
    landing.deepest = std::max(landing.deepest, -low);
    if (low > out_of_reach && std::isfinite(before))
      landing.rise = std::max(landing.rise, m.total() - before);
    before = low > out_of_reach ? m.total() : no_value;
  }
  return landing;
}

/// `series` gets every tenth sample.
void rest(const Subject& subject, double seconds, Recorder& recorder, Table& series) {
  Trial trial(subject, 0.5, 0.4);
  const Landing landing = land(trial, seconds);
  const auto add = [&](Study study, double value) {
    recorder.add(study, subject, 0.5, 0, trial, {.value = value, .expected = 0, .error = value});
  };
  add(Study::rest, landing.kinetic.empty() ? no_value : landing.kinetic.back() / landing.peak);
  add(Study::depth, landing.deepest / trial.cell_size());
  add(Study::flight, landing.rise / landing.peak);
  for (std::size_t i = 0; i < landing.t.size(); i += 10)
    series.add({to_string(subject.law), subject.integrator, landing.t[i], landing.kinetic[i] / landing.peak});
}

using LawRun = std::function<void(Recorder&, Table&)>;

/// All runs in the order of the table.
std::vector<LawRun> law_runs(const ContactConfig& config) {
  std::vector<LawRun> all;
  const auto subjects = [&](BodyKind kind, const BodyConfig& body, const std::vector<std::string>& methods) {
    std::vector<Subject> some;
    for (const ContactLaw law : config.laws)
      for (const std::string& method : methods)
        if (law == ContactLaw::penalty || find_integrator(method).stepping == Stepping::fixed)
          some.push_back({method, law, kind, body});
    return some;
  };
  const auto particles = subjects(BodyKind::particle, free_particles(), config.integrators);
  const auto blocks = subjects(BodyKind::block, rubber_block(), config.block_integrators);
  for (const Subject& s : particles)
    for (const double e : config.restitutions)
      all.emplace_back([=](Recorder& recorder, Table&) { bounce(s, e, recorder); });
  for (const auto* bodies : {&particles, &blocks})
    for (const Subject& s : *bodies) {
      for (const double mu : config.frictions)
        for (const double degrees : config.degrees)
          all.emplace_back([=](Recorder& recorder, Table&) { stop(s, mu, degrees, recorder); });
      for (const double mu : config.slope_frictions)
        all.emplace_back([=](Recorder& recorder, Table&) { slide(s, mu, recorder); });
    }
  for (const Subject& s : subjects(BodyKind::thesis_cube, thesis_cube(), config.block_integrators))
    all.emplace_back([s, seconds = config.rest_seconds](Recorder& recorder, Table& series) {
      rest(s, seconds, recorder, series);
    });
  return all;
}

}  // namespace

double expected_slide(double friction) { return reference::slope_distance(gravity, slope, friction, 1); }

namespace {

Table empty_rows() {
  return Table({{"study"},
                {"law"},
                {"integrator"},
                {"body"},
                {"coefficient"},
                {"angle", "degrees"},
                {"dt", "s"},
                {"value"},
                {"expected"},
                {"error"},
                {"status"}});
}

Table empty_rest() { return Table({{"law"}, {"integrator"}, {"t", "s"}, {"kinetic_over_peak"}}); }

Json compute(const LawRun& run) {
  Table rows = empty_rows(), rest = empty_rest();
  Recorder recorder(rows);
  run(recorder, rest);
  return {{"rows", rows_of(rows)}, {"rest", rows_of(rest)}};
}

Json compute(const FloorRun& run) {
  Table rows = empty_floor();
  add_floor_run(run, rows);
  return {{"floor", rows_of(rows)}};
}

Json compute(const BarRun& run) {
  Table rows = empty_bars();
  add_bar_run(run, rows);
  return {{"bars", rows_of(rows)}};
}

Json compute(const BalanceRun& run) {
  Table rows = empty_balance();
  add_balance_run(run, rows);
  return {{"balance", rows_of(rows)}};
}

Json compute(const PressRun& run) {
  Table rows = empty_spheres();
  add_press_run(run, rows);
  return {{"spheres", rows_of(rows)}};
}

Json compute(const ImpactRun& run) {
  Table rows = empty_impacts();
  add_impact_run(run, rows);
  return {{"impacts", rows_of(rows)}};
}

template <class Run>
void add_cases(const std::vector<Run>& runs, std::vector<Case>& cases) {
  for (const Run& run : runs) cases.push_back({run.name(), [run] { return compute(run); }});
}

std::vector<Case> cases_of(const ContactConfig& config) {
  std::vector<Case> cases;
  for (const LawRun& run : law_runs(config))
    cases.push_back({fmt::format("laws, run {}", cases.size() + 1), [run] { return compute(run); }});
  add_cases(floor_runs(config.floor), cases);
  add_cases(config.collision.bars, cases);
  add_cases(config.collision.blocks, cases);
  add_cases(config.sphere.pressed, cases);
  add_cases(config.sphere.impacts, cases);
  for (Case& one : robustness_cases(config.robustness)) cases.push_back(std::move(one));
  for (Case& one : cases) one.group = one.name;
  return cases;
}

/// Only the charted method's kinetic energies are kept.
void add_result(const Json& result, ContactTables& tables) {
  if (add_robustness_result(result, tables.robustness)) return;
  for (const auto& [name, table] :
       {std::pair{"floor", &tables.floor}, std::pair{"bars", &tables.bars},
        std::pair{"balance", &tables.balance}, std::pair{"spheres", &tables.spheres},
        std::pair{"impacts", &tables.impacts}})
    if (result.contains(name)) return add_rows(result[name], *table);
  add_rows(result["rows"], tables.rows);
  Table rest = empty_rest();
  add_rows(result["rest"], rest);
  if (rest.size() > 0 && rest.text(0, "integrator") == charted_integrator(tables.rows))
    add_rows(result["rest"], tables.rest);
}

}  // namespace

ContactTables measure_contact(const ContactConfig& config, int processes, Journal& journal,
                              Progress& progress) {
  ContactTables tables{.rows = empty_rows(),
                       .rest = empty_rest(),
                       .floor = empty_floor(),
                       .bars = empty_bars(),
                       .balance = empty_balance(),
                       .spheres = empty_spheres(),
                       .impacts = empty_impacts()};
  tables.status = gather_cases(cases_of(config), processes, journal, progress,
                               [&](const Json& result) { add_result(result, tables); });
  return tables;
}

}  // namespace mss::studies::contact
