#include "experiments/view/session.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/simulation/reduced_model.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_run.hpp"

namespace mss::view {

namespace {

constexpr double frame = 1.0 / 60;
constexpr std::size_t longest_history = 1500;

}  // namespace

/// A body's system, method and state, whatever the precision they are in.
class Simulation {
 public:
  Simulation() = default;
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  virtual ~Simulation() = default;

  virtual Status advance(double t_end, Work& work) = 0;
  virtual Status fetch() = 0;
  virtual std::optional<Measures> measure() const = 0;
  virtual Session::BodyOnDevice on_device() = 0;
  virtual double time() const = 0;
  virtual const std::vector<Level>& levels() const = 0;
  virtual std::ptrdiff_t size() const = 0;
  virtual std::size_t particle_count() const = 0;
  virtual bool moves_by_itself(std::ptrdiff_t site) const = 0;
  virtual double dt() const = 0;
  virtual void read(Field<double>& x, Field<double>& v) const = 0;
  virtual void write(double t, const Field<double>& x, const Field<double>& v) = 0;
  virtual Tether stable_tether(std::ptrdiff_t site) const = 0;
  virtual void tie(const std::optional<Tether>& tether) = 0;
};

namespace {

template <class Real>
class SimulationIn : public Simulation {
 public:
  SimulationIn(const Scene& scene, const Body& body) : run_(scene, body), tethered_(run_.driven()) {
    run_.leave_on_device();
  }

  Status advance(double t_end, Work& work) override { return run_.advance(tethered_, t_end, work); }
  Status fetch() override { return run_.fetch(); }
  std::optional<Measures> measure() const override { return run_.measure(); }
  Session::BodyOnDevice on_device() override {
    if (DeviceSystem<Real>* body = run_.on_device()) return body;
    return {};
  }
  double time() const override { return run_.state().t; }
  const std::vector<Level>& levels() const override { return run_.system().levels(); }
  std::ptrdiff_t size() const override { return run_.system().size(); }
  std::size_t particle_count() const override { return run_.system().particles().size(); }
  bool moves_by_itself(std::ptrdiff_t site) const override { return run_.system().mass(site) > 0; }
  double dt() const override { return run_.dt(); }
  void read(Field<double>& x, Field<double>& v) const override {
    for (const auto& [body, first] : levels())
      for (const std::ptrdiff_t site : body.sites()) {
        x.set(first + site, run_.state().x.at(first + site));
        v.set(first + site, run_.state().v.at(first + site));
      }
  }
  void write(double t, const Field<double>& x, const Field<double>& v) override {
    State<Real> state = run_.state();
    state.t = t;
    for (const auto& [body, first] : levels())
      for (const std::ptrdiff_t site : body.sites()) {
        state.x.set(first + site, x.at(first + site));
        state.v.set(first + site, v.at(first + site));
      }
    run_.go_on_from(state);
  }
  Tether stable_tether(std::ptrdiff_t site) const override {
    return mss::stable_tether(run_.system().mass(site), run_.bound(), site);
  }
  void tie(const std::optional<Tether>& tether) override {
    run_.fetch();
    tethered_.tie(tether);
    run_.disturb();
  }

 private:
  SceneRun<Real> run_;
  TetheredSystem<Real> tethered_;
};

/// Moves the body as it was moved before.
class Playback final : public SimulationIn<double> {
 public:
  Playback(const Scene& scene, const Body& body, const Motion& motion)
      : SimulationIn(scene, body), motion_(motion) {
    go_to(motion_.front().t);
  }
  Status advance(double t_end, Work&) override {
    go_to(t_end);
    return Status::ok;
  }

 private:
  /// On the straight line between the states before and after; at the last one from its time on.
  void go_to(double t) {
    const auto after = std::find_if(motion_.begin(), std::prev(motion_.end()),
                                    [t](const State<double>& state) { return state.t >= t; });
    const State<double>&b = *after, &a = after == motion_.begin() ? b : *std::prev(after);
    const double share = b.t > a.t ? std::clamp((t - a.t) / (b.t - a.t), 0.0, 1.0) : 1.0;
    Field<double> x = b.x, v = b.v;
    for (const std::ptrdiff_t site : levels().front().body.sites()) {
      x.set(site, (1 - share) * a.x.at(site) + share * b.x.at(site));
      v.set(site, (1 - share) * a.v.at(site) + share * b.v.at(site));
    }
    write(t, x, v);
  }

  const Motion& motion_;
};

std::unique_ptr<Simulation> simulation_of(const Scene& scene, const Body& body) {
  if (scene.solve.precision == Precision::single) return std::make_unique<SimulationIn<float>>(scene, body);
  return std::make_unique<SimulationIn<double>>(scene, body);
}

}  // namespace

Session::Session(const Scene& scene) : Session(scene, Motion{}) {}

Session::Session(const Scene& scene, Motion motion)
    : scene_(scene), settings_(edit_of(scene)), motion_(std::move(motion)) {
  check_solve(scene_);
  body_ = std::make_unique<Body>(scene_.body);
  restart();
}

Session::~Session() = default;

double Session::dt() const { return simulation_->dt(); }

const std::vector<Level>& Session::levels() const { return simulation_->levels(); }

std::size_t Session::cell_count() const {
  std::size_t count = 0;
  for (const Level& level : levels()) count += level.body.cell_count();
  return count;
}

std::size_t Session::particle_count() const { return simulation_->particle_count(); }

void Session::restart() {
  release();
  if (motion_.empty())
    simulation_ = simulation_of(scene_, *body_);
  else
    simulation_ = std::make_unique<Playback>(scene_, *body_, motion_);
  status_ = Status::ok;
  work_ = {};
  x_ = v_ = Field<double>(simulation_->size());
  read_state();
  forget_target();
  history_.clear();
  record();
  start_ = history_.front();
}

/// Copies the state of the simulation, unless a device has it.
void Session::read_state() {
  t_ = simulation_->time();
  is_behind_ = simulation_->on_device().index() > 0;
  if (is_behind_) return;
  simulation_->read(x_, v_);
  fetched_at_ = t_;
}

/// The state of the simulation from a device.
void Session::fetch() const {
  if (!is_behind_) return;
  if (const Status found = simulation_->fetch(); found != Status::ok) {
    status_ = found;
    is_behind_ = false;
    return;
  }
  simulation_->read(x_, v_);
  fetched_at_ = t_;
  is_behind_ = false;
  ++fetches_;
}

Session::BodyOnDevice Session::body_on_device() const {
  if (status_ != Status::ok) return {};
  return simulation_->on_device();
}

void Session::advance(double seconds) {
  if (status_ != Status::ok) return;
  target_ += seconds;
  status_ = simulation_->advance(target_, work_);
  if (status_ == Status::ok) return read_state();
  is_behind_ = false;
  t_ = fetched_at_;
}

double Session::advance_within(double seconds, double budget) {
  const Stopwatch watch;
  const double least = seconds / 64;
  double done = 0, slice = least;
  while (done < seconds && status_ == Status::ok) {
    advance(slice);
    done += slice;
    const double elapsed = watch.seconds();
    if (elapsed >= budget) break;
    slice = std::min(std::max(least, done * (budget - elapsed) / elapsed),
                     seconds - done);  // as much as the budget allows
  }
  return done;
}

void Session::step() {
  forget_target();
  const bool fixed = find_integrator(settings_.integrator).stepping == Stepping::fixed;
  advance(fixed ? dt() : frame);
}

void Session::change(const SceneEdit& settings) {
  if (!motion_.empty()) throw InputError("a motion that was computed elsewhere has no settings to change");
  Scene scene = edited(scene_, settings);
  check_solve(scene);
  auto body = std::make_unique<Body>(scene.body);
  auto simulation = simulation_of(scene, *body);
  simulation->write(t_, positions(), velocities());
  if (tether_) {  // a pull as strong as the new material allows
    const Vec3 anchor = tether_->anchor;
    tether_ = simulation->stable_tether(tether_->site);
    tether_->anchor = anchor;
    simulation->tie(tether_);
  }
  simulation_ = std::move(simulation);  // first: the old one refers to the old body
  body_ = std::move(body);
  scene_ = std::move(scene);
  settings_ = settings;
  forget_target();
}

bool Session::grab(std::ptrdiff_t site) {
  const HeldSites held(levels(), scene_.environment.holds);
  if (!motion_.empty() || reduction_named(scene_.model) || !simulation_->moves_by_itself(site)) return false;
  if (held.holds(site, 0) && held.holds(site, 1) && held.holds(site, 2)) return false;
  tether_ = simulation_->stable_tether(site);
  pull(positions().at(site));
  return true;
}

void Session::pull(const Vec3& anchor) {
  tether_->anchor = anchor;
  simulation_->tie(tether_);
}

void Session::release() {
  tether_.reset();
  if (simulation_) simulation_->tie(tether_);
}

std::optional<Session::Pull> Session::pulled() const {
  if (!tether_) return std::nullopt;
  return Pull{positions().at(tether_->site), tether_->anchor};
}

void Session::record() {
  if (status_ != Status::ok) return;
  fetch();
  if (status_ != Status::ok) return;
  const std::optional<Measures> measures = simulation_->measure();
  if (!measures) status_ = Status::non_finite;
  if (status_ != Status::ok && !history_.empty()) return;
  if (history_.size() == longest_history) history_.pop_front();
  history_.push_back(measures.value_or(Measures{}));
}

}  // namespace mss::view
