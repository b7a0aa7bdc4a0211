#include "integrators/integrator.hpp"

#include <fmt/format.h>

#include <tuple>

#include "core/base/error.hpp"
#include "core/base/record.hpp"
#include "integrators/collisions.hpp"

namespace mss {

namespace {

std::string no_relaxation(const IntegratorInfo& method) {
  return fmt::format(
      "{} {}, and material.relaxation needs forces that do; leave it out, or give damped_verlet or tr_bdf2",
      method.name,
      method.needs_springs() || !method.has_modulus
          ? "moves springs in its own way, which does not relax"
          : "has stages that no relaxation of second order follows");
}

/// Throws InputError where a method does not tell a system's memory what it has to.
template <class Real>
void check_memory(const IntegratorInfo& method, System<Real>& system) {
  StepMemory<Real>* memory = system.memory();
  if (memory && memory->limits_order() && !method.relaxes) throw InputError(no_relaxation(method));
  if (memory && memory->matters() && method.stepping == Stepping::adaptive)
    throw InputError(fmt::format(
        "contact between bodies depends on where steps end, and {} tries steps; leave [contact] out, or give "
        "another solve.integrator",
        method.name));
}

std::vector<std::string> methods_on_devices() {
  std::vector<std::string> names;
  for (const IntegratorInfo& info : integrators())
    if (info.make_double_on_device) names.push_back(info.name);
  return names;
}

/// Throws InputError where a method of particles meets a body that follows a few coordinates, or the reverse.
template <class Real>
void check_coordinates(const IntegratorInfo& method, System<Real>& system) {
  const bool is_for_reduced = method.stepping == Stepping::reduced;
  if (is_for_reduced && !system.reduced())
    throw InputError(
        fmt::format("{} steps the coordinates of a reduced body, and this one's particles move by "
                    "themselves; give material.model = \"modal\", or another solve.integrator",
                    method.name));
  if (!is_for_reduced && system.reduced())
    throw InputError(
        fmt::format("{} moves particles one by one, and a reduced body's follow a few coordinates; give "
                    "solve.integrator = \"reduced\", or material.model = \"springs\"",
                    method.name));
}

}  // namespace

template <class Real>
std::unique_ptr<Integrator<Real>> IntegratorInfo::make(const IntegratorOptions& options) const {
  const bool on_device = options.device != "cpu";
  const auto& [here, there] = [&] {
    if constexpr (std::is_same_v<Real, float>)
      return std::tie(make_single, make_single_on_device);
    else
      return std::tie(make_double, make_double_on_device);
  }();
  if (on_device && !make_double_on_device)
    throw InputError(
        fmt::format("integrator '{}' takes no steps on a device; give one of {}, or device = \"cpu\"", name,
                    fmt::join(methods_on_devices(), ", ")));
  if (!here)
    throw InputError(
        fmt::format("integrator '{}' computes in double precision only; give precision = \"double\"", name));
  std::unique_ptr<Integrator<Real>> method = (on_device ? there : here)(options);
  method->collisions_ = collisions;
  method->check_ = [facts = *this, dt = options.dt](System<Real>& system) {
    check_coordinates(facts, system);
    check_collisions(facts, system, dt);
    check_memory(facts, system);
    if (system.in_local_steps() && !facts.local_steps)
      throw InputError(
          fmt::format("{} has more than one force a step, and local steps take the place of one; "
                      "leave solve.local_steps out, or give verlet",
                      facts.name));
  };
  return method;
}
template std::unique_ptr<Integrator<float>> IntegratorInfo::make(const IntegratorOptions&) const;
template std::unique_ptr<Integrator<double>> IntegratorInfo::make(const IntegratorOptions&) const;

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
    case Status::device_lost:
      return "device_lost";
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

void Work::remember(Record& record) {
  record.keep(steps, force_evaluations, jacobians, factorisations, linear_solves, products);
}

}  // namespace mss
