#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>

#include "core/base/record.hpp"
#include "core/measures/measures.hpp"
#include "core/measures/reactions.hpp"
#include "core/refinement/refined_body.hpp"
#include "core/scene/scene.hpp"
#include "experiments/simulation/model.hpp"
#include "integrators/analysis/error_scale.hpp"
#include "integrators/device/state_on_device.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// The bodies of a scene as they start: at rest, in their holds, moving and spinning as [start] says of each.
template <class Real>
State<Real> start_state(const SolidSystem<Real>& system, const Scene& scene);

/// True if all numbers are finite.
bool is_finite(const Measures& measures);

/// Options of the scene's method: its step resolved, errors of adaptive methods scaled (error_scale.hpp).
/// Throws InputError if dt is "safe" and no step is.
template <class Real>
IntegratorOptions method_options(const Scene& scene, const SolidSystem<Real>& system);

/// Steps of a method up to which small motions are sure to be stable [s]; of methods that choose their steps
/// infinite.
struct SureSteps {
  double free = std::numeric_limits<double>::infinity();
  double guarded = std::numeric_limits<double>::infinity();  ///< if the fold guard acts everywhere
};

/// Stops of a method of fixed steps on its way, to look at the state. Nothing that is computed depends on
/// them.
class Stops {
 public:
  virtual ~Stops() = default;
  /// Steps until the next one, 1 or more.
  virtual long steps() = 0;
  /// False: the advance ends here, as interrupted, unless this was its end.
  virtual bool reached(bool at_end) = 0;
};

/// A scene being simulated: its system, its method, its state, and the strikes still to come.
template <class Real>
class SceneRun {
 public:
  /// The body, which is the scene's first without refinement, must outlive it. Adaptive methods may take
  /// `most_steps` in one advance.
  SceneRun(const Scene& scene, const Body& body, long most_steps = IntegratorOptions{}.most_steps);

  SolidSystem<Real>& system() { return *system_; }
  const SolidSystem<Real>& system() const { return *system_; }
  const State<Real>& state() const { return state_; }
  /// Of adaptive methods the first; 0 if that is their choice [s].
  double dt() const { return options_.dt; }
  /// As Integrator's.
  std::string device() const { return method_->device(); }
  double transfer_seconds() const { return method_->transfer_seconds() - transfers_before_; }
  /// Kinetic energy that strikes have added [J].
  double struck() const { return struck_; }

  /// What methods drive: the system, or the same in local steps.
  System<Real>& driven() { return in_local_steps_ ? *in_local_steps_ : *system_; }
  /// What limits their steps.
  SpectralBound bound() const { return in_local_steps_ ? system_->local_bound() : system_->spectral_bound(); }
  SureSteps sure_steps() const;
  /// Whether some cells take longer steps than others.
  bool in_local_steps() const { return bound().omega < (1 - 1e-9) * system_->spectral_bound().omega; }

  /// As Integrator::advance(), with the strikes on the way; drives `driven`, which stands for driven().
  Status advance(System<Real>& driven, double t_end, Work& work, Stops* stops = nullptr);
  /// The way to `goal`, of which an advance goes the first part, and what is called on it.
  struct Journey {
    double goal = 0;                      ///< [s]
    long group = 1;                       ///< steps that methods take at once, by which t is counted
    std::function<void()> at_last_group;  ///< where what goes on from there computes what the whole way would
  };
  /// With fixed steps only.
  Status advance_towards(const Journey& journey, double t_end, Work& work, Stops& stops);
  Status advance(double t_end, Work& work, Stops* stops = nullptr) {
    return advance(driven(), t_end, work, stops);
  }

  /// Of the state; nothing if a number is not finite: energies overflow before coordinates do.
  std::optional<Measures> measure() const;

  /// What holds and planes exert, by planes that give impulses the mean since begin_means(), or since the
  /// state was set; `driven` as above.
  Reactions reactions(System<Real>& driven) { return gauge_.read(driven, state_); }
  void begin_means() { gauge_.begin(state_.t); }

  /// Continues from another state. Strikes before its time are past.
  void go_on_from(const State<Real>& state);
  /// Keeps in a record, or takes from one, all that later advances depend on (core/base/record.hpp), also
  /// where stops have interrupted one.
  void remember(Record& record);
  /// Goes on with another method than the scene's.
  void use(std::unique_ptr<Integrator<Real>> method);
  /// To be called after anything that acts on the body has changed.
  void disturb();

  /// Lets a method on a device leave the state there between advances; not that of a body that is struck on
  /// the way. Then state() is what the last fetch() found, but for its time.
  void leave_on_device();
  /// On Status::device_lost, which all later advances give too, the state is that of the last time, time
  /// included.
  Status fetch();
  /// The body whose state was left there; nullptr: state() has it.
  DeviceSystem<Real>* on_device() { return left_ ? left_->body() : nullptr; }

 private:
  /// Steps to a time as they were counted where the way to it began: counted again on it, half a step may
  /// round to one more.
  struct Way {
    double goal = 0;  ///< [s]
    long left = 0;

    void remember(Record& record) { record.keep(goal, left); }
  };

  Status advance_between_strikes(System<Real>& driven, double t_end, Work& work, Stops* stops);
  Status take_steps(System<Real>& driven, long steps, Way way, double t_end, Work& work, Stops& stops);
  long steps_to(double t_end) const;
  double end_of_steps(long steps, bool last, double t_end) const;

  std::vector<Strike> strikes_;  ///< by time
  std::size_t next_ = 0;         ///< strike
  double struck_ = 0;
  const Journey* journey_ = nullptr;            ///< of the advance, if it ends before the goal
  std::optional<Way> way_;                      ///< that an advance has not gone to its end
  std::unique_ptr<const RefinedBody> refined_;  ///< where the scene refines
  OtherBodies others_;                          ///< where it has several bodies
  std::unique_ptr<SolidSystem<Real>> system_;
  IntegratorOptions options_;
  std::unique_ptr<System<Real>> in_local_steps_;  ///< where the scene has them
  std::unique_ptr<Integrator<Real>> method_;
  double transfers_before_ = 0;          ///< the run
  Status of_device_ = Status::ok;        ///< device_lost: what was left there is gone
  StateOnDevice<Real>* left_ = nullptr;  ///< of method_, if the state is left there
  const IntegratorInfo* info_;           ///< of the scene's method
  State<Real> state_;
  ReactionGauge<Real> gauge_;
};

}  // namespace mss
