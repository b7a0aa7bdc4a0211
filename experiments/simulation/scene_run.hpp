#pragma once

#include <memory>

#include "core/body_system.hpp"
#include "core/scene.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// The body of a scene as it starts: at rest, in its holds, moving and spinning as [start] says.
template <class Real>
State<Real> start_state(const BodySystem<Real>& system, const Scene& scene);

/// Lets adaptive methods measure local errors against the size of a cell, and of velocities against a tenth
/// of the speed at which the fastest mode would cross one: vibrations ten times slower than that still have
/// errors of the same share in position and velocity.
template <class Real>
void scale_errors(IntegratorOptions& options, const BodySystem<Real>& system);

/// What the scene's method is made with: its step resolved, errors of adaptive methods scaled as above.
/// Throws InputError if dt is "safe" and no step is.
template <class Real>
IntegratorOptions method_options(const Scene& scene, const BodySystem<Real>& system);

/// A scene under way: its system, its method, its state, and the strikes it has yet to get.
template <class Real>
class SceneRun {
 public:
  /// The body must outlive it. Adaptive methods may take `most_steps` in one advance.
  SceneRun(const Scene& scene, const Body& body, long most_steps = IntegratorOptions{}.most_steps);

  BodySystem<Real>& system() { return *system_; }
  const BodySystem<Real>& system() const { return *system_; }
  const State<Real>& state() const { return state_; }
  /// Of adaptive methods the first; 0 if that is their choice [s].
  double dt() const { return options_.dt; }

  /// As Integrator::advance(), with the strikes on the way; drives `driven`, which stands for the system.
  Status advance(System<Real>& driven, double t_end, Work& work);
  Status advance(double t_end, Work& work) { return advance(*system_, t_end, work); }

  /// Goes on from another state. Strikes before it have been given.
  void go_on_from(const State<Real>& state);
  /// What acts from outside has changed.
  void disturb();

 private:
  std::vector<Strike> strikes_;  ///< by time
  std::size_t next_ = 0;         ///< strike
  std::unique_ptr<BodySystem<Real>> system_;
  IntegratorOptions options_;
  std::unique_ptr<Integrator<Real>> method_;
  State<Real> state_;
};

}  // namespace mss
