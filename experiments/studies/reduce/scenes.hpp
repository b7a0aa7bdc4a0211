#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/system/system.hpp"
#include "experiments/simulation/moving_body.hpp"

namespace mss::studies::reduce {

/// A box of rubber-like material, density 1000 kg/m^3, nu = 0.3, clamped at its face x = 0 or free.
struct Solid {
  std::string name{};
  Vec3 size = Vec3::Ones();  ///< [m]
  int cells = 16;            ///< along x
  double young = 1e7;        ///< [Pa]
  bool clamped = true;

  /// Its extent along an axis in cells, of which there are so many along x.
  int cells_along(int axis, int along_x) const;
};

/// What happens to a body.
enum class Happening {
  gravity,  ///< it is let go under gravity
  release,  ///< a load on its end face, at rest with which it begins, is taken away
  twist,    ///< its end face, turned, is let go
  patch,    ///< a load presses on a patch of its top
  contact,  ///< under gravity its tip meets a plane
  spin      ///< free, it turns
};

struct ReduceScene {
  std::string name{};         ///< in tables
  std::string label{};        ///< on charts
  std::string description{};  ///< for people
  std::size_t solid = 0;      ///< index of its body
  Happening happening = Happening::gravity;
  Vec3 amount = Vec3::Zero();  ///< gravity [m/s^2], force [N], turn [degrees] or rate [rad/s]
  /// Largest mean displacement of the end face that it is meant to have, over the length; 0: none is stated.
  double meant = 0;
  bool losses = false;  ///< is tried with models that lose, too; under gravity
};

/// Moduli and springs of a lattice that stands for a body.
struct LatticeChoice {
  int cells = 16;  ///< along x
  double young = 1e7, poisson = 0.3, face_share = 0.5;
};

/// The scene on a lattice, as the program's scene files would have it. `model` of the material.
Scene scene_on(const ReduceScene& scene, const Solid& solid, const LatticeChoice& lattice,
               const std::string& model = spring_model);

/// How the scene begins on the springs of a lattice; throws std::runtime_error if what it begins from has no
/// equilibrium.
State<double> start_of(const ReduceScene& scene, const Solid& solid, const Scene& on_lattice,
                       const Body& body);

/// Mean over the particles of the end face [m].
Vec3 end_displacement(const Solid& solid, const Body& body, const Field<double>& x);

/// Empty if a motion did what its scene is meant to do, or in words what it did instead.
std::string reduce_complaint(const ReduceScene& scene, const Solid& solid, const Body& body,
                             const State<double>& start, const FramePositions& motion);

}  // namespace mss::studies::reduce
