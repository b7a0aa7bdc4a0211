#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/studies/reduce/drawing.hpp"
#include "experiments/studies/reduce/scenes.hpp"

namespace mss::studies::reduce {

/// One way to move the body of a scene and to draw all of its particles.
class Mover {
 public:
  Mover() = default;
  Mover(const Mover&) = delete;
  Mover& operator=(const Mover&) = delete;
  virtual ~Mover() = default;

  /// Back to where the scene begins.
  virtual void restart() = 0;
  /// Goes on for a frame.
  virtual Status advance() = 0;
  /// Positions of the body's particles now, valid until it goes on [m].
  virtual const Field<double>& draw() = 0;
  /// Steps of a frame.
  virtual long steps() const = 0;
};

/// A method in steps of dt [s] with the options that it has of its own.
struct Stepper {
  std::string integrator;
  IntegratorOptions options;
};

/// The best explicit one for a system: velocity Verlet at 0.9 of its largest stable step.
Stepper explicit_stepper(BodySystem<double>& system, bool contact);

/// The springs of a lattice, by an explicit method if none is given; drawn by interpolation if its cells are
/// not the body's.
std::unique_ptr<Mover> lattice_mover(const ReduceScene& scene, const Solid& solid,
                                     const LatticeChoice& lattice, const Body& body,
                                     const std::optional<Stepper>& stepper = std::nullopt);

/// The body with a model that reduces it, from a start on its own lattice, which must outlive it. Throws
/// InputError as make_solid() does, and if the model does not reduce bodies.
std::unique_ptr<Mover> reduced_mover(const Scene& scene, const Body& body, const State<double>& start);
/// What a run of so many frames is warned of.
std::vector<std::string> reduced_warnings(Scene scene, const Body& body, const State<double>& start,
                                          int frames);
/// A mover of a system that reduces a body of its own.
std::unique_ptr<Mover> reduced_mover(std::unique_ptr<const Body> body,
                                     std::unique_ptr<SolidSystem<double>> system, const State<double>& start);

}  // namespace mss::studies::reduce
