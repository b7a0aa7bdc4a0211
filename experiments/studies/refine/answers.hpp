#pragma once

#include <memory>
#include <optional>

#include "core/refinement/refined_body.hpp"
#include "core/springs/solid_system.hpp"
#include "experiments/studies/refine/maps.hpp"

namespace mss::studies::refine {

/// A body in its environment.
struct Solid {
  Solid(const BodyConfig& config, const RefinementMap& map, const Environment& environment);
  RefinedBody body;
  std::unique_ptr<SolidSystem<double>> system;
};

/// What a body says to a problem.
struct Answer {
  Status status = Status::ok;
  Field<double> displacement{};         ///< what the estimate of its error is computed from [m]
  std::optional<Field<double>> dual{};  ///< and that of what is looked at, where it is not under the load
  double value = no_value;              ///< in the quantity's unit
  double period = no_value;             ///< of the slowest vibration where that was looked for [s]
  double seconds = no_value;            ///< of finding it, matrices included
};

/// As tables spell it, with its unit.
std::string to_string(Quantity quantity);

Answer answer(Solid& solid, const MapProblem& problem);

/// The slowest vibration that is not a rigid motion, as an answer.
Answer slowest_vibration(Solid& solid);

/// A force of size 1 along a direction, spread evenly over a flat box on the surface of a body whose
/// lattices are given: what each corner of a cell's face gets is the integral of its bilinear weight over
/// what the box covers of the face. Throws InputError if the box covers no face.
Field<double> traction(const std::vector<Level>& levels, const Box& patch, const Vec3& direction);

}  // namespace mss::studies::refine
