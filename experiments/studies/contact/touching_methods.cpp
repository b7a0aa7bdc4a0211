#include "experiments/studies/contact/touching_methods.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "integrators/integrator.hpp"

namespace mss::studies::contact {

bool is_of_high_order(const std::string& integrator) {  // RK4 stays, as the usual one
  return integrator == "pefrl" || integrator == "srkn6" || integrator == "srkn8";
}

std::vector<std::string> touching_methods(const std::vector<std::string>& named) {
  std::vector<std::string> methods = named;
  if (named.empty())
    for (const IntegratorInfo& info : integrators())
      if (info.nonlinear_solver.empty() && !is_of_high_order(info.name)) methods.push_back(info.name);
  std::erase_if(methods, [](const std::string& name) {
    const IntegratorInfo& info = find_integrator(name);
    return info.stepping != Stepping::fixed || info.needs_springs() || !info.has_modulus ||
           !info.nonlinear_solver.empty();
  });
  return methods;
}

std::string solve_text(const std::string& integrator, double duration, double every) {
  const std::string step =
      find_integrator(integrator).limit ? "\"safe\"" : fmt::format("{:.17g}", frame_step);
  return fmt::format(
      "[solve]\nintegrator = \"{}\"\ndt = {}\nduration = {:.17g}\nevery = {:.17g}\nthreads = 1\n", integrator,
      step, duration, every);
}

}  // namespace mss::studies::contact
