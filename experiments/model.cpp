#include "experiments/model.hpp"

#include <fmt/format.h>

#include <type_traits>

#include "core/error.hpp"
#include "core/spring_system.hpp"
#include "core/suggest.hpp"
#include "reference/fem/fem_system.hpp"

namespace mss {

namespace {

/// nullptr for springs.
const SolidLaw* find_law(const std::string& model) {
  if (model == spring_model) return nullptr;
  std::vector<std::string> names{spring_model};
  for (const SolidLaw& law : solid_laws()) {
    if (law.name == model) return &law;
    names.push_back(law.name);
  }
  throw_unknown(model, names, "model", "models");
}

}  // namespace

std::vector<std::pair<std::string, std::string>> models() {
  std::vector<std::pair<std::string, std::string>> lines{
      {spring_model, "the springs and volume force of each cell, through the structured sweep"}};
  for (const SolidLaw& law : solid_laws()) lines.emplace_back(law.name, law.summary);
  return lines;
}

void check_model_name(const std::string& model) { find_law(model); }

void check_model(const std::string& model, const BodyConfig& body, bool single_precision) {
  if (find_law(model) == nullptr) return;
  if (!body.elastic)
    throw InputError(fmt::format(
        "model '{}' needs material.young and material.poisson, and material.springs are given", model));
  if (single_precision)
    throw InputError(
        fmt::format("model '{}' computes in double precision only; give precision = \"double\"", model));
}

void tell_model(Chart& chart, const std::string& model) {
  if (model != spring_model) chart.subtitle += "; " + model + " finite elements";
}

template <class Real>
std::unique_ptr<BodySystem<Real>> make_system(const std::string& model, const Body& body,
                                              const Environment& environment, int threads) {
  check_model(model, body.config(), std::is_same_v<Real, float>);
  const SolidLaw* law = find_law(model);
  if (law == nullptr)
    return std::make_unique<SpringSystem<Real>>(body, environment, Execution{.threads = threads});
  if constexpr (std::is_same_v<Real, double>)
    return std::make_unique<FemSystem>(body, environment, *law, threads);
  else
    return nullptr;  // refused above
}

template std::unique_ptr<BodySystem<float>> make_system(const std::string&, const Body&, const Environment&,
                                                        int);
template std::unique_ptr<BodySystem<double>> make_system(const std::string&, const Body&, const Environment&,
                                                         int);

}  // namespace mss
