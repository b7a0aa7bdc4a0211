#include "integrators/reduction/reduced_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/base/error.hpp"
#include "integrators/reduction/cubic_motion.hpp"
#include "integrators/reduction/floating_motion.hpp"
#include "integrators/reduction/warped_motion.hpp"

namespace mss {

namespace {

bool is_free(const Environment& environment) { return environment.holds.empty(); }

void check(const Body& body, const Environment& environment, Reduction reduction) {
  const auto check_law = [](ContactLaw law) {
    if (law != ContactLaw::penalty)
      throw InputError(fmt::format(
          "contact = \"{}\" changes velocities of particles, which a reduced body's have none of their own; "
          "give contact = \"penalty\", or material.model = \"springs\"",
          law == ContactLaw::impulse ? "impulse" : "thesis"));
  };
  for (const Plane& plane : environment.planes) check_law(plane.contact);
  for (const Obstacle& obstacle : environment.obstacles) check_law(obstacle.contact);
  if (body.config().relaxation.acts())
    throw InputError(
        "material.relaxation is of springs, and a reduced body has none; leave it out, or give "
        "material.model = \"springs\"");
  if (is_free(environment) && reduction != Reduction::modal)
    throw InputError(
        "this model is for bodies that are held, and nothing holds this one; give material.model = "
        "\"modal\", whose frame floats with the body, or a [[hold]]");
}

int modes_of(const ReductionChoice& choice, bool free) {
  if (choice.modes > 0) return choice.modes;
  if (free) return 18;
  return choice.reduction == Reduction::cubic ? 16 : 8;
}

}  // namespace

ReducedShapes shapes_for(const Body& body, const Environment& environment, const ReductionChoice& choice) {
  check(body, environment, choice.reduction);
  RestBody rest(body, environment);
  const int modes = modes_of(choice, rest.is_free());
  if (rest.is_free()) return centrifugal_shapes(rest, modes);
  if (choice.reduction == Reduction::cubic) return derivative_shapes(rest, modes);
  return modal_shapes(rest, environment, modes);
}

ReducedSystem::ReducedSystem(const Body& body, const Environment& environment, const ReductionChoice& choice,
                             const ReducedShapes& shapes)
    : BodySystem<double>(body, environment, mss::spectral_bound(body), 1),
      lattice_(body, environment, Execution{.threads = 1}) {
  check(body, environment, choice.reduction);
  const std::vector<Load>& loads = environment.loads;
  const bool presses = contact().has_penalties();
  OuterForces outer{
      .change_in_time =
          std::any_of(loads.begin(), loads.end(), [](const Load& load) { return !load.history.empty(); }),
      .depend_on_state = presses,
      .turns = presses || !loads.empty(),
      .nothing = !presses && loads.empty() && environment.gravity.isZero(0),
      .at = [this](double t, const State<double>& state, Field<double>& f) { add_outer(t, state, f); }};
  if (presses) {
    const double pressed = contact().with_penalties({.omega = 0}).omega;
    outer.longest_step = 1.8 / std::hypot(pressed, std::sqrt(shapes.squares.maxCoeff()));
  }
  const State<double> rest = rest_state();
  if (is_free(environment))
    motion_ = std::make_unique<FloatingMotion>(*this, rest, shapes, std::move(outer));
  else if (choice.reduction == Reduction::cubic)
    motion_ = std::make_unique<CubicMotion>(*this, body, rest, shapes, std::move(outer));
  else if (choice.reduction == Reduction::warped)
    motion_ = std::make_unique<WarpedMotion>(*this, body, rest, shapes, std::move(outer));
  else
    motion_ = std::make_unique<ModalMotion>(*this, rest, shapes, std::move(outer));
}

StoredEnergy ReducedSystem::stored_energy(const Field<double>& x) const {
  return {.elastic = motion_->stored_energy(x)};
}

void ReducedSystem::add_outer(double t, const State<double>& state, Field<double>& f) {
  f.array() = 0;
  add_gravity(f);
  loads().add(t, 0, size(), std::array<double*, 3>{f.axis(0), f.axis(1), f.axis(2)});
  add_penalty_force(t, state.x, state.v, f);
}

}  // namespace mss
