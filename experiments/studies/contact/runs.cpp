// The runs of `mss validate contact`.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>

#include "core/measures.hpp"
#include "core/spring_system.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/contact/contact.hpp"
#include "reference/closed_forms.hpp"

namespace mss::studies::contact {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double gravity = 9.81;       ///< [m/s^2]
constexpr double longest_step = 1e-3;  ///< [s]; half the limit of central differences if that is shorter
const double slope = std::atan(0.5);

/// What is tried: a method, a law, a body.
struct Subject {
  std::string integrator;
  ContactLaw law = ContactLaw::impulse;
  std::string body;
  BodyConfig config{};
  int threads = 1;
};

/// A method at work on a body on the ground z = 0, under gravity that leans by an angle along x.
class Trial {
 public:
  Trial(const Subject& subject, double restitution, double friction, double angle = 0)
      : body_(subject.config),
        system_(body_,
                {.gravity = gravity * Vec3(std::sin(angle), 0, -std::cos(angle)),
                 .planes = {{.contact = subject.law, .restitution = restitution, .friction = friction}}},
                {.threads = subject.threads}),
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
  /// Takes over how another one ended.
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

/// What one run answers.
struct Answer {
  double value = none, expected = none;
  double error = none;  ///< of the heights or the distance, as a share of it
};

class Recorder {
 public:
  explicit Recorder(Table& rows) : rows_(rows) {}
  void add(const std::string& study, const Subject& subject, double asked, double degrees, const Trial& trial,
           const Answer& answer) {
    const bool ok = trial.status() == Status::ok;
    const bool found = std::isfinite(answer.value) && std::isfinite(answer.error);
    rows_.add({study, to_string(subject.law), subject.integrator, subject.body, asked, degrees, trial.dt(),
               ok && found ? answer.value : none, answer.expected, ok && found ? answer.error : none,
               std::string(ok && !found ? "not found" : mss::to_string(trial.status()))});
  }

 private:
  Table& rows_;
};

/// Highest points after a number of bounces, of a particle dropped from a height of 1 m; fewer if time runs
/// out.
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
  constexpr double lowest = 0.01;  // bounces below drown in the spacing of samples
  int bounces = 1;
  while (bounces < 4 && reference::bounce_height(1, restitution, bounces + 1) >= lowest) ++bounces;
  Trial trial(subject, restitution, 0.4);
  const double fall = std::sqrt(2 / gravity);
  const std::vector<double> tops = heights(trial, bounces, fall * (2 + 2 * bounces));
  Answer answer{.expected = restitution};
  if (restitution == 0) {  // it should have stayed
    answer.error = tops.empty() ? 0 : std::max(0.0, tops.front());
    answer.value = std::sqrt(answer.error);
  } else if (int(tops.size()) == bounces) {
    answer.value = std::pow(tops.back(), 0.5 / bounces);
    answer.error = 0;
    for (int k = 1; k <= bounces; ++k)
      answer.error = std::max(
          answer.error, std::abs(tops[std::size_t(k - 1)] / reference::bounce_height(1, restitution, k) - 1));
  }
  recorder.add("bounce", subject, restitution, 0, trial, answer);
}

/// The friction that would have stopped a push where the run ended.
void stop(const Subject& subject, double friction, double degrees, Recorder& recorder) {
  constexpr double speed = 2;
  const double angle = degrees * std::numbers::pi / 180;
  Trial trial(subject, 0.5, friction);
  if (subject.body == "particle") trial.put_on_ground();
  trial.push(speed * Vec3(std::cos(angle), std::sin(angle), 0));
  const Vec3 start = trial.centre();
  trial.advance(1.5 * speed / (friction * gravity));
  Vec3 moved = trial.centre() - start;
  moved[2] = 0;
  const double expected = reference::stopping_distance(gravity, speed, friction);
  recorder.add("stop", subject, friction, degrees, trial,
               {.value = speed * speed / (2 * gravity * moved.norm()),
                .expected = friction,
                .error = std::abs(moved.norm() / expected - 1)});
}

/// How far a body slides in a second. A block first settles glued to the slope, and is let go some time
/// before, because the strain of sticking goes with a jerk.
void slide(const Subject& subject, double friction, Recorder& recorder) {
  constexpr double settling = 0.6, glue = 10, one_second = 1;
  const double run_in = subject.body == "particle" ? 0 : 0.4;
  Trial trial(subject, 0, friction, slope);
  if (subject.body == "particle") {
    trial.put_on_ground();
  } else {
    Trial glued(subject, 0, glue, slope);
    glued.advance(settling);
    trial.begin(glued);
    trial.advance(run_in);
  }
  const Vec3 start = trial.centre(), velocity = trial.velocity();
  trial.advance(run_in + one_second);
  const double value = (trial.centre() - start)[0] - velocity[0] * one_second;
  const double expected = expected_slide(friction), frictionless = expected_slide(0);
  recorder.add("slope", subject, friction, 0, trial,
               {.value = value,
                .expected = expected,
                .error = std::abs(value - expected) / (expected > 0 ? expected : frictionless)});
}

/// What is seen of a cube that is dropped spinning.
struct Landing {
  double peak = 0;     ///< of its kinetic energy [J]
  double deepest = 0;  ///< below the ground [m]
  double rise = 0;     ///< of its energy from look to look while it cannot have touched [J]
  std::vector<double> t, kinetic;
};

Landing land(Trial& trial, double seconds) {
  constexpr double look = 0.01;                       // [s]
  const double out_of_reach = trial.cell_size() / 4;  // it cannot have touched since the last look
  Landing landing;
  double before = none;
  trial.push({1, 0, 0}, {3, 2, 1});
  for (long i = 1; double(i) * look <= seconds && trial.advance(double(i) * look); ++i) {
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
    before = low > out_of_reach ? m.total() : none;
  }
  return landing;
}

void rest(const Subject& subject, const ContactConfig& config, Recorder& recorder, Table& table) {
  Trial trial(subject, 0.5, 0.4);
  const Landing seen = land(trial, config.rest_seconds);
  const auto add = [&](const std::string& study, double value) {
    recorder.add(study, subject, 0.5, 0, trial, {.value = value, .expected = 0, .error = value});
  };
  add("rest", seen.kinetic.empty() ? none : seen.kinetic.back() / seen.peak);
  add("depth", seen.deepest / trial.cell_size());
  add("flight", seen.rise / seen.peak);
  if (subject.integrator != charted_integrator(config)) return;
  for (std::size_t i = 0; i < seen.t.size(); i += 10)
    table.add({to_string(subject.law), subject.integrator, seen.t[i], seen.kinetic[i] / seen.peak});
}

/// Everything to be run, in the order of the table.
std::vector<std::function<void(Recorder&, Table&)>> runs(const ContactConfig& config) {
  std::vector<std::function<void(Recorder&, Table&)>> all;
  const auto subjects = [&](const std::string& name, const BodyConfig& body,
                            const std::vector<std::string>& methods) {
    std::vector<Subject> some;
    for (const ContactLaw law : config.laws)
      for (const std::string& method : methods)
        if (law == ContactLaw::penalty || find_integrator(method).stepping == Stepping::fixed)
          some.push_back({method, law, name, body, config.threads});
    return some;
  };
  const auto particles = subjects("particle", free_particles(), config.integrators);
  const auto blocks = subjects("block", rubber_block(), config.block_integrators);
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
  for (const Subject& s : subjects("thesis's cube", thesis_cube(), config.block_integrators))
    all.emplace_back([=, &config](Recorder& recorder, Table& table) { rest(s, config, recorder, table); });
  return all;
}

}  // namespace

double expected_slide(double friction) { return reference::slope_distance(gravity, slope, friction, 1); }

ContactTables measure_contact(const ContactConfig& config, Progress& progress) {
  ContactTables tables{Table({{"study"},
                              {"law"},
                              {"integrator"},
                              {"body"},
                              {"asked"},
                              {"angle", "degrees"},
                              {"dt", "s"},
                              {"value"},
                              {"expected"},
                              {"error"},
                              {"status"}}),
                       Table({{"law"}, {"integrator"}, {"t", "s"}, {"kinetic_over_peak"}})};
  Recorder recorder(tables.rows);
  const auto all = runs(config);
  for (std::size_t i = 0; i < all.size(); ++i) {
    progress.report(double(i) / double(all.size()), fmt::format("run {} of {}", i + 1, all.size()));
    if (progress.stopped()) {
      tables.status = Status::interrupted;
      break;
    }
    all[i](recorder, tables.rest);
  }
  return tables;
}

}  // namespace mss::studies::contact
