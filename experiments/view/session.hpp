#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/state.hpp"
#include "core/environment/tethered_system.hpp"
#include "core/measures/measures.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/scene_edit.hpp"
#include "core/springs/body_system.hpp"
#include "integrators/integrator.hpp"

namespace mss {
template <class Real>
class DeviceSystem;
}

namespace mss::view {

class Simulation;

/// States at ascending times, between which particles move straight: at least one.
using Motion = std::vector<State<double>>;

/// The simulation that a window shows: what `mss run` would compute, but it can be stopped, pulled and
/// changed. It stays usable when the simulation fails: the body is then shown in its last state.
class Session {
 public:
  /// Throws InputError as check_solve() does.
  explicit Session(const Scene& scene);
  /// Shows a motion of the scene's body in place of a simulation, from its first state to its last. It has no
  /// settings to change, and cannot be pulled. Several levels of cells are not supported.
  Session(const Scene& scene, Motion motion);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// The scene with the settings in force.
  const Scene& scene() const { return scene_; }
  const SceneEdit& settings() const { return settings_; }
  /// Without refinement.
  const Body& body() const { return *body_; }
  const std::vector<Level>& levels() const;
  std::size_t cell_count() const;
  std::size_t particle_count() const;

  double time() const { return t_; }  ///< [s]
  double dt() const;                  ///< [s]; of adaptive methods the first, 0 if that is their choice
  std::int64_t steps() const { return work_.steps; }
  Status status() const { return status_; }

  /// Positions [m] and velocities [m/s] of all particles.
  const Field<double>& positions() const {
    fetch();
    return x_;
  }
  const Field<double>& velocities() const {
    fetch();
    return v_;
  }

  /// The body, if a device has its state; it is then fetched for positions() and velocities(), for
  /// record() and where a particle is tied only, and after a failure they are the last that were fetched.
  using BodyOnDevice = std::variant<std::monostate, DeviceSystem<float>*, DeviceSystem<double>*>;
  BodyOnDevice body_on_device() const;
  /// How often that was so.
  long fetches() const { return fetches_; }

  /// Simulates this many seconds, in whole steps of methods that have them; the remainder is carried over to
  /// the next call. Does nothing after a failure.
  void advance(double seconds);

  /// The same in slices, until they have taken as long as `budget` [s]; at least one. Returns the seconds
  /// simulated.
  double advance_within(double seconds, double budget);

  /// One step; of methods without steps of their own, 1/60 s.
  void step();

  /// Back to the start, with the settings in force.
  void restart();

  /// Puts other settings in force. Positions and velocities stay. Throws InputError if they
  /// cannot be simulated; nothing has changed then.
  void change(const SceneEdit& settings);

  /// Ties a particle to the point where it is. False if it cannot move by itself: it is held, or hangs.
  bool grab(std::ptrdiff_t site);
  /// Takes that point elsewhere. Only while a particle is grabbed.
  void pull(const Vec3& anchor);
  void release();
  /// Where the tied particle is, and where it is pulled to.
  struct Pull {
    Vec3 from, to;
  };
  std::optional<Pull> pulled() const;

  /// Measures the body and adds that to history(). Energies that are not finite are a failure.
  void record();
  const Measures& measures() const { return history_.back(); }
  /// The last ones recorded, oldest first; at least one.
  const std::deque<Measures>& history() const { return history_; }
  /// What they were at the start.
  const Measures& start() const { return start_; }

 private:
  void read_state();
  void fetch() const;
  void forget_target() { target_ = t_; }

  Scene scene_;
  SceneEdit settings_;
  Motion motion_{};  ///< empty: a simulation is shown
  std::unique_ptr<Body> body_;
  std::unique_ptr<Simulation> simulation_;
  double t_ = 0;
  double target_ = 0;  ///< time that was requested, which whole steps need not reach [s]
  mutable Field<double> x_, v_;
  mutable double fetched_at_ = 0;   ///< time of these, behind t_ if `is_behind_` [s]
  mutable bool is_behind_ = false;  ///< a device has later ones
  mutable long fetches_ = 0;
  mutable Status status_ = Status::ok;
  Work work_;
  std::optional<Tether> tether_;
  std::deque<Measures> history_;
  Measures start_;
};

}  // namespace mss::view
