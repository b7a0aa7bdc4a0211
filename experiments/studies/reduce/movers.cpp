#include "experiments/studies/reduce/movers.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "core/base/error.hpp"
#include "core/system/reduced_motion.hpp"
#include "experiments/simulation/reduced_watch.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::reduce {

namespace {

/// A frame's steps that are no longer than one.
long steps_of(double longest) { return std::max(1L, long(std::ceil(frame / longest * (1 - 1e-12)))); }

class LatticeMover final : public Mover {
 public:
  LatticeMover(const ReduceScene& scene, const Solid& solid, const LatticeChoice& lattice, const Body& fine,
               const std::optional<Stepper>& stepper)
      : scene_(scene_on(scene, solid, lattice)),
        body_(scene_.body),
        system_(make_system<double>(spring_model, body_, scene_.environment, 1)),
        start_(start_of(scene, solid, scene_, body_)),
        stepper_(stepper ? *stepper : explicit_stepper(*system_, scene.happening == Happening::contact)) {
    if (body_.particle_count() == fine.particle_count()) return;
    interpolation_.emplace(body_, fine);
    drawn_ = Field<double>(fine.lattice().size);
  }

  void restart() override {
    state_ = start_;
    frames_ = 0;
    method_ = find_integrator(stepper_.integrator).make<double>(stepper_.options);
  }

  Status advance() override {
    Work work;
    const Status status = method_->advance(*system_, state_, ++frames_ * frame, work);
    return status == Status::ok && !is_finite(state_) ? Status::non_finite : status;
  }

  const Field<double>& draw() override {
    if (!interpolation_) return state_.x;
    interpolation_->draw(state_.x, drawn_);
    return drawn_;
  }

  long steps() const override { return std::lround(frame / stepper_.options.dt); }

 private:
  Scene scene_;
  Body body_;
  std::unique_ptr<BodySystem<double>> system_;
  State<double> start_, state_;
  Stepper stepper_;
  std::unique_ptr<Integrator<double>> method_;
  std::optional<Trilinear> interpolation_;
  Field<double> drawn_;
  int frames_ = 0;
};

class ReducedMover final : public Mover {
 public:
  ReducedMover(std::unique_ptr<const Body> body, std::unique_ptr<SolidSystem<double>> system,
               const State<double>& start)
      : body_(std::move(body)), system_(std::move(system)), start_(start), drawn_(start.x) {
    steps_ = steps_of(system_->reduced()->longest_step());
  }

  void restart() override { system_->reduced()->take(start_); }
  Status advance() override {
    return system_->reduced()->step(frame / double(steps_), steps_) ? Status::ok : Status::non_finite;
  }
  const Field<double>& draw() override {
    system_->reduced()->draw(drawn_);
    return drawn_;
  }
  long steps() const override { return steps_; }

 private:
  std::unique_ptr<const Body> body_;  ///< the system's; nullptr: another's
  std::unique_ptr<SolidSystem<double>> system_;
  const State<double>& start_;
  Field<double> drawn_;
  long steps_ = 1;
};

}  // namespace

Stepper explicit_stepper(BodySystem<double>& system, bool contact) {
  const std::string name = "velocity_verlet";
  const IntegratorInfo& info = find_integrator(name);
  // The bound knows planes, the prediction about a body at rest does not.
  double limit = stable_step(info, system.spectral_bound());
  if (!contact) {
    Work work;
    const PredictedStep predicted = predicted_step(info, system, system.undeformed_state(), work);
    if (predicted.status == Status::ok) limit = predicted.dt;
  }
  return {name, {.dt = frame / double(steps_of(safe_share * limit))}};
}

std::unique_ptr<Mover> lattice_mover(const ReduceScene& scene, const Solid& solid,
                                     const LatticeChoice& lattice, const Body& body,
                                     const std::optional<Stepper>& stepper) {
  return std::make_unique<LatticeMover>(scene, solid, lattice, body, stepper);
}

std::unique_ptr<Mover> reduced_mover(const Scene& scene, const Body& body, const State<double>& start) {
  std::unique_ptr<SolidSystem<double>> system = make_solid<double>(scene, body, nullptr, {});
  if (!system->reduced()) throw InputError(fmt::format("model '{}' reduces no bodies", scene.model));
  return reduced_mover(nullptr, std::move(system), start);
}

std::vector<std::string> reduced_warnings(Scene scene, const Body& body, const State<double>& start,
                                          int frames) {
  scene.solve.integrator = "reduced";
  SceneRun<double> run(scene, body);
  run.go_on_from(start);
  ReducedWatch<double> watch(run);
  Work work;
  for (int i = 1; i <= frames && run.advance(i * frame, work) == Status::ok; ++i)
    if (const std::optional<Measures> measures = run.measure())
      watch.add(*measures, run.reactions(run.driven()));
  return warnings_of(scene, *watch.found());
}

std::unique_ptr<Mover> reduced_mover(std::unique_ptr<const Body> body,
                                     std::unique_ptr<SolidSystem<double>> system,
                                     const State<double>& start) {
  return std::make_unique<ReducedMover>(std::move(body), std::move(system), start);
}

}  // namespace mss::studies::reduce
