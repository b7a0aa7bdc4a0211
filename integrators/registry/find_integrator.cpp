#include <fmt/format.h>

#include <charconv>
#include <map>
#include <mutex>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "integrators/integrator.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

namespace {

/// 5 in "vbd:5"; 0 where there is none.
int iterations_in(std::string_view name) {
  constexpr int most = 1000;
  const std::size_t colon = name.find(':');
  if (colon == std::string_view::npos) return 0;
  const std::string_view digits = name.substr(colon + 1);
  int number = 0;
  const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (problem != std::errc{} || end != digits.data() + digits.size() || number < 1 || number > most)
    throw InputError(
        fmt::format("'{}' is no number of iterations in '{}'; allowed: 1 to {}", digits, name, most));
  return number;
}

/// "lbfgs" in "backward_euler/lbfgs:5"; empty where there is none.
std::string solver_in(std::string_view name) {
  const std::string family = family_of(name);
  const std::size_t slash = family.find('/');
  return slash == std::string::npos ? "" : family.substr(slash + 1);
}

template <class Real>
using Make = std::function<std::unique_ptr<Integrator<Real>>(const IntegratorOptions&)>;

template <class Real>
Make<Real> with(const Make<Real>& make, const std::string& solver, int iterations) {
  if (!make) return {};
  return [make, solver, iterations](IntegratorOptions options) {
    if (!solver.empty()) options.nonlinear_solver = solver;
    if (iterations > 0) options.iterations = iterations;
    return make(options);
  };
}

IntegratorInfo variant(const std::string& name) {
  IntegratorInfo info =
      find_named(integrators(), name.substr(0, name.find_first_of("/:")), "integrator", "integrators");
  const std::string solver = solver_in(name);
  const int iterations = iterations_in(name);
  if (!info.iterates)
    throw InputError(
        fmt::format("{} does not iterate, as '{}' would; leave out what follows its name", info.name, name));
  if (solver.empty() && family_of(name).find('/') != std::string::npos)
    throw InputError(
        fmt::format("'{}' names no nonlinear solver after its /; name one, or leave the / out", name));
  if (!solver.empty() && !info.implicit)
    throw InputError(
        fmt::format("{} needs no nonlinear solver, which '{}' names; leave it out", info.name, name));
  if (!solver.empty()) find_nonlinear_solver(solver);
  info.name = name;
  info.nonlinear_solver = solver;
  info.variants.clear();
  info.make_single = with<float>(info.make_single, solver, iterations);
  info.make_double = with<double>(info.make_double, solver, iterations);
  info.make_single_on_device = with<float>(info.make_single_on_device, solver, iterations);
  info.make_double_on_device = with<double>(info.make_double_on_device, solver, iterations);
  return info;
}

}  // namespace

std::string family_of(std::string_view name) { return std::string(name.substr(0, name.find(':'))); }

const IntegratorInfo& find_integrator(std::string_view name) {
  if (name.find_first_of("/:") == std::string_view::npos)
    return find_named(integrators(), name, "integrator", "integrators");
  static std::mutex guard;
  static std::map<std::string, IntegratorInfo, std::less<>> variants;
  const std::lock_guard lock(guard);
  auto known = variants.find(name);
  if (known == variants.end()) known = variants.emplace(name, variant(std::string(name))).first;
  return known->second;
}

}  // namespace mss
