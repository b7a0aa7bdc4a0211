#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "core/body_system.hpp"
#include "core/measures.hpp"
#include "core/scene.hpp"
#include "core/tethered_system.hpp"
#include "integrators/integrator.hpp"

namespace mss::view {

/// What may be changed about a scene while it runs.
struct Settings {
  std::optional<ElasticConstants> elastic;  ///< empty: `springs` are given
  SpringConstants springs{};  ///< with `elastic`, what follows from it; its volume force is kept
  double face_share = 0.5;    ///< of springs that follow from `elastic`
  bool volume_force = true;
  Damping damping{};
  Topology topology = Topology::full;
  std::string integrator;
  std::optional<double> dt;  ///< [s]; empty: "safe"
};

/// The settings a scene file asks for.
Settings settings_of(const Scene& scene);

class Simulation;

/// The simulation that a window shows: what `mss run` would do, but stopped, pushed and changed on the way.
/// It stays usable when the simulation fails: the body is then shown as it last was.
class Session {
 public:
  /// Throws InputError as check_solve() does.
  explicit Session(const Scene& scene);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// The scene with the settings in force.
  const Scene& scene() const { return scene_; }
  const Settings& settings() const { return settings_; }
  const Body& body() const { return *body_; }

  double time() const { return t_; }  ///< [s]
  double dt() const;                  ///< [s]; of adaptive methods the first, 0 if that is their choice
  std::int64_t steps() const { return work_.steps; }
  Status status() const { return status_; }

  /// Positions [m] and velocities [m/s] of all particles.
  const Field<double>& positions() const { return x_; }
  const Field<double>& velocities() const { return v_; }

  /// Lets this many seconds pass, in whole steps of methods that have them: what is left over is made up for
  /// the next time. Does nothing after a failure.
  void advance(double seconds);

  /// The same in slices, until they have taken as long as `budget` [s]; at least one. Returns the seconds
  /// simulated.
  double advance_within(double seconds, double budget);

  /// One step; of methods without steps of their own, 1/60 s.
  void step();

  /// Back to the start, with the settings in force.
  void restart();

  /// Puts other settings in force. The body stays where it is and as fast as it is. Throws InputError if they
  /// cannot be simulated; nothing has changed then.
  void change(const Settings& settings);

  /// Ties a particle to the point where it is. False if it cannot move, being held.
  bool grab(std::ptrdiff_t site);
  /// Takes that point elsewhere. Only while a particle is grabbed.
  void pull(const Vec3& anchor);
  void release();
  /// Where the tied particle is, and where it is pulled to.
  struct Pull {
    Vec3 from, to;
  };
  std::optional<Pull> pulled() const;

  /// Measures the body as it is, and keeps that for history(). Energies that are no numbers are a failure.
  void record();
  const Measures& measures() const { return history_.back(); }
  /// The last ones recorded, oldest first; at least one.
  const std::deque<Measures>& history() const { return history_; }
  /// What they were at the start.
  const Measures& start() const { return start_; }

 private:
  void make_motion();
  void take_over();
  void forget_target() { target_ = t_; }

  Scene scene_;
  Settings settings_;
  std::unique_ptr<Body> body_;
  std::unique_ptr<Simulation> simulation_;
  double t_ = 0;
  double target_ = 0;  ///< where time would be without steps [s]
  Field<double> x_, v_;
  Status status_ = Status::ok;
  Work work_;
  std::optional<Tether> tether_;
  std::deque<Measures> history_;
  Measures start_;
};

}  // namespace mss::view
