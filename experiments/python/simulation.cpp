#include "experiments/python/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/base/error.hpp"
#include "core/bodies/bodies_measures.hpp"
#include "core/measures/cell_stress.hpp"
#include "experiments/python/callbacks.hpp"
#include "experiments/simulation/diagnostics.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_run.hpp"

namespace mss::python {

namespace py = pybind11;

namespace {

/// Held by whoever uses a simulation. Throws std::runtime_error where another thread does.
class Use {
 public:
  explicit Use(std::atomic<bool>& used) : used_(used) {
    if (used_.exchange(true))
      throw std::runtime_error(
          "this simulation is computing; use it from one thread, and what its functions are given within "
          "them");
  }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;
  ~Use() { used_ = false; }

 private:
  std::atomic<bool>& used_;
};

template <class Real>
class SimulationIn final : public Simulation {
 public:
  explicit SimulationIn(const Scene& scene) : scene_(scene), body_(scene_.body), run_(scene_, body_) {
    if constexpr (std::is_same_v<Real, double>) forced_ = std::make_unique<ForcedSystem>(run_.system());
  }

  const Scene& scene() const override { return scene_; }
  const std::vector<Level>& levels() const override { return run_.system().levels(); }
  double dt() const override { return run_.dt(); }
  double time() const override {
    const Use use(used_);
    return run_.state().t;
  }
  const Work& work() const override {
    const Use use(used_);
    return work_;
  }
  Doubles positions() const override {
    const Use use(used_);
    return vectors_of(run_.state().x, run_.system().particles());
  }
  Doubles velocities() const override {
    const Use use(used_);
    return vectors_of(run_.state().v, run_.system().particles());
  }
  Doubles forces() override;
  Doubles cell_stress(bool damping) const override;
  py::dict measures() override;
  void advance(double until) override;
  void set_state(double t, const Doubles& x, const Doubles& v) override;
  void add_force(py::function force) override;
  void set_integrator(py::function step) override;

 private:
  /// Python functions compute in double precision.
  void refuse_single_precision() const {
    if (!forced_)
      throw InputError(fmt::format(
          "{} computes in single precision; set solve.precision to \"double\" for functions in Python",
          scene_.name));
  }
  System<Real>& driven() {
    if constexpr (std::is_same_v<Real, double>) return *forced_;
    return run_.system();
  }
  Status advance_unlocked(double until);

  const Scene scene_;
  const Body body_;
  SceneRun<Real> run_;
  std::unique_ptr<ForcedSystem> forced_;  ///< of double precision
  bool calls_python_ = false;
  Work work_;
  mutable std::atomic<bool> used_ = false;
};

template <class Real>
Doubles SimulationIn<Real>::forces() {
  const Use use(used_);
  const State<Real>& state = run_.state();
  Field<Real> forces(driven().size());
  {
    const py::gil_scoped_release free;
    driven().force(state.t, state.x, state.v, forces);
  }
  if (forced_) forced_->rethrow();
  return vectors_of(forces, run_.system().particles());
}

template <class Real>
Doubles SimulationIn<Real>::cell_stress(bool damping) const {
  const Use use(used_);
  CellStress stress;
  {
    const py::gil_scoped_release free;
    State<Real> state = run_.state();
    if (!damping) state.v.array() = 0;
    stress = mss::cell_stress(run_.system(), state);
  }
  if (!stress)
    throw InputError(
        fmt::format(R"({}: the model "{}" does not know the stress of its cells; choose "springs")",
                    scene_.name, scene_.model));
  Doubles array({py::ssize_t(stress->size()), py::ssize_t(3), py::ssize_t(3)});
  double* out = array.mutable_data();
  for (const Eigen::Matrix3d& of_cell : *stress) out = std::copy_n(of_cell.data(), 9, out);  // symmetric
  return array;
}

template <class Real>
py::dict SimulationIn<Real>::measures() {
  const Use use(used_);
  Measures measures;
  Reactions reactions;
  BodiesMeasures bodies;
  {
    const py::gil_scoped_release free;
    measures = mss::measure(run_.system(), run_.state());
    bodies = measure_bodies(run_.system(), run_.state());
    reactions = run_.reactions(driven());
  }
  if (forced_) forced_->rethrow();
  py::dict named;
  for (const MeasureColumn& column : columns_of(measures))
    named[py::str(std::string(column.name))] = column.value(measures);
  const auto add = [&](const std::string& name, double number) { named[py::str(name)] = number; };
  for_each_component(reactions, add);
  for_each_column(bodies, [&](const std::string& name, const char*, double number) { add(name, number); });
  return named;
}

template <class Real>
Status SimulationIn<Real>::advance_unlocked(double until) {
  const py::gil_scoped_release free;
  return run_.advance(driven(), until, work_);
}

template <class Real>
void SimulationIn<Real>::advance(double until) {
  const Use use(used_);
  if (!(std::isfinite(until) && until >= run_.state().t - run_.dt()))
    throw InputError(
        fmt::format("advance({:.9g}) is not ahead; give a time after {:.9g} s", until, run_.state().t));
  std::optional<State<Real>> before;
  if (calls_python_) before = run_.state();
  Status status = Status::ok;
  run_.begin_means();
  try {
    status = advance_unlocked(until);
    if (forced_) forced_->rethrow();
  } catch (...) {
    if (before) run_.go_on_from(*before);
    throw;
  }
  if (status == Status::ok) return;
  const SureSteps sure = run_.sure_steps();
  const std::string diagnostic = status == Status::non_finite && std::isfinite(sure.free) && !calls_python_
                                     ? "; " + diagnosis_of_divergence(scene_, run_.dt(), sure)
                                     : std::string();
  throw SimulationFailed(fmt::format("{}: {} after {} steps, at t = {:.9g} s{}", scene_.name,
                                     to_string(status), work_.steps, run_.state().t, diagnostic));
}

template <class Real>
void SimulationIn<Real>::set_state(double t, const Doubles& x, const Doubles& v) {
  const Use use(used_);
  State<Real> state = run_.state();
  state.t = t;
  set_vectors(state.x, run_.system().particles(), x, "positions");
  set_vectors(state.v, run_.system().particles(), v, "velocities");
  if (!std::isfinite(t) || !is_finite(state))
    throw InputError(
        "the state has numbers that are not finite; give finite times, positions and velocities");
  run_.go_on_from(state);
}

template <class Real>
void SimulationIn<Real>::add_force(py::function force) {
  const Use use(used_);
  refuse_single_precision();
  if (scene_.solve.sleep.bound > 0)
    throw InputError(
        fmt::format("{} lets particles sleep, which would not feel a function's force; set solve.sleep to 0",
                    scene_.name));
  if (driven().reduced())
    throw InputError(
        fmt::format("{}: material.model = \"{}\" moves few coordinates, which a function's force does not "
                    "reach; give \"springs\"",
                    scene_.name, scene_.model));
  forced_->add(std::move(force));
  calls_python_ = true;
  run_.disturb();
}

template <class Real>
void SimulationIn<Real>::set_integrator(py::function step) {
  const Use use(used_);
  refuse_single_precision();
  if constexpr (std::is_same_v<Real, double>) {
    if (run_.dt() <= 0)
      throw InputError(
          fmt::format("{} chooses its own steps; set solve.integrator to a method of fixed step, "
                      "or solve.dt to a number of seconds",
                      scene_.solve.integrator));
    run_.use(std::make_unique<PythonMethod>(std::move(step), run_.dt()));
    calls_python_ = true;
  }
}

}  // namespace

std::unique_ptr<Simulation> make_simulation(const Scene& scene) {
  check_solve(scene);
  if (is_refined(scene))
    throw InputError(fmt::format(
        "{}: arrays are of bodies with cells of one size; leave [[refine]] and body.refinement out",
        scene.file.string()));
  if (scene.solve.precision == Precision::single) return std::make_unique<SimulationIn<float>>(scene);
  return std::make_unique<SimulationIn<double>>(scene);
}

}  // namespace mss::python
