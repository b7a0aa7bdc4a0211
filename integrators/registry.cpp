// The list of methods is in CMakeLists.txt beside this file: the line that compiles a method also registers
// it.
#include <fmt/format.h>

#include "core/error.hpp"
#include "core/suggest.hpp"
#include "integrators/integrator.hpp"

namespace mss {

#define MSS_METHOD(name) IntegratorInfo name();
#include "integrators/methods.inc"
#undef MSS_METHOD

const std::vector<IntegratorInfo>& integrators() {
  static const std::vector<IntegratorInfo> all{
#define MSS_METHOD(name) name(),
#include "integrators/methods.inc"
#undef MSS_METHOD
  };
  return all;
}

const IntegratorInfo& find_integrator(std::string_view name) {
  std::vector<std::string> known;
  for (const IntegratorInfo& info : integrators()) {
    if (info.name == name) return info;
    known.push_back(info.name);
  }
  throw InputError(
      fmt::format("integrator '{}' is unknown; did you mean '{}'? `mss list integrators` shows all", name,
                  nearest(name, known)));
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
