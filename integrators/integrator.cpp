#include "integrators/integrator.hpp"

#include "core/suggest.hpp"

namespace mss {

const IntegratorInfo& find_integrator(std::string_view name) {
  return find_named(integrators(), name, "integrator", "integrators");
}

std::string_view to_string(Status status) {
  switch (status) {
    case Status::ok:
      return "ok";
    case Status::non_finite:
      return "non_finite";
    case Status::newton_stalled:
      return "newton_stalled";
    case Status::not_positive_definite:
      return "not_positive_definite";
    case Status::linear_stalled:
      return "linear_stalled";
    case Status::step_limit:
      return "step_limit";
    case Status::tolerance_missed:
      return "tolerance_missed";
    case Status::interrupted:
      return "interrupted";
  }
  return "unknown";
}

Work& Work::operator+=(const Work& other) {
  steps += other.steps;
  force_evaluations += other.force_evaluations;
  jacobians += other.jacobians;
  factorisations += other.factorisations;
  linear_solves += other.linear_solves;
  products += other.products;
  return *this;
}

}  // namespace mss
