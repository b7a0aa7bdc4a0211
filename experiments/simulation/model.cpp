#include "experiments/simulation/model.hpp"

#include <fmt/format.h>

#include <functional>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "core/bodies/bodies_system.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/simulation/reduced_model.hpp"
#include "integrators/analysis/chosen_refinement.hpp"
#include "reference/fem/fem_system.hpp"
#include "reference/mollemans.hpp"

namespace mss {

namespace {

/// What may fill a body in double precision; springs compute in single precision too.
struct Model {
  std::string name;
  std::string summary;
  bool of_elastic_constants;  ///< needs elastic constants, which given springs do not determine
  std::function<std::unique_ptr<BodySystem<double>>(const Body&, const Environment&, const Execution&)> make;
};

std::vector<Model> make_models() {
  std::vector<Model> all{
      {spring_model, "the springs and volume force of each cell, through the structured sweep", false,
       [](const Body& body, const Environment& environment, const Execution& execution) {
         return std::make_unique<SpringSystem<double>>(body, environment, execution);
       }},
      {mollemans_model, "springs with Mollemans's volume force on tetrahedra (eq. 1-1, its sign turned)",
       false, [](const Body& body, const Environment& environment, const Execution& execution) {
         return std::make_unique<MollemansSystem>(body, environment, execution.threads);
       }}};
  for (const SolidLaw& law : solid_laws())
    all.push_back({law.name, law.summary, true,
                   [law](const Body& body, const Environment& environment, const Execution& execution) {
                     return std::make_unique<FemSystem>(body, environment, law, execution.threads);
                   }});
  for (const auto& [name, summary] : std::initializer_list<std::pair<const char*, const char*>>{
           {"modal", "a few vibrations, each by its exact solution; free bodies float. For small motions"},
           {"modal_warped", "the same, particles turned as vibrations turn them. For bending and twist"},
           {"modal_cubic",
            "vibrations and their second-order answers with the full force there. For bending"}})
    all.push_back({name, summary, false,
                   [name = std::string(name)](const Body& body, const Environment& environment,
                                              const Execution&) -> std::unique_ptr<BodySystem<double>> {
                     const ReductionChoice choice{.reduction = *reduction_named(name)};
                     return std::make_unique<ReducedSystem>(body, environment, choice,
                                                            shapes_for(body, environment, choice));
                   }});
  return all;
}

const std::vector<Model>& all_models() {
  static const std::vector<Model> all = make_models();
  return all;
}

const Model& find_model(const std::string& name) {
  std::vector<std::string> names;
  for (const Model& model : all_models()) {
    if (model.name == name) return model;
    names.push_back(model.name);
  }
  throw_unknown(name, names, "model", "models");
}

}  // namespace

std::vector<std::pair<std::string, std::string>> models() {
  std::vector<std::pair<std::string, std::string>> lines;
  for (const Model& model : all_models()) lines.emplace_back(model.name, model.summary);
  return lines;
}

void check_model_name(const std::string& model) { find_model(model); }

void check_model(const std::string& name, const BodyConfig& body, bool single_precision) {
  const Model& model = find_model(name);
  if (model.of_elastic_constants && !body.elastic)
    throw InputError(fmt::format(
        "model '{}' needs material.young and material.poisson, and material.springs are given", name));
  if (body.fold_guard != 0 && !has_springs(name))
    throw InputError(fmt::format(
        "model '{}' has no fold guard, and material.fold_guard is given; it is for springs", name));
  if (!body.is_solid() && name != spring_model)
    throw InputError(
        fmt::format("model '{}' fills cells of three dimensions, and body.cells make {}; give model \"{}\"",
                    name, body.noun(), spring_model));
  if (single_precision && name != spring_model)
    throw InputError(
        fmt::format("model '{}' computes in double precision only; give precision = \"double\"", name));
}

void add_model_to_subtitle(Chart& chart, const std::string& model) {
  if (model != spring_model) chart.subtitle += "; model: " + model;
}

namespace {

template <class Real>
std::unique_ptr<SolidSystem<Real>> make_several(const Scene& scene, const Body& first,
                                                const OtherBodies& others) {
  std::vector<const Body*> bodies{&first};
  for (const auto& other : others) bodies.push_back(other.get());
  const BodyThreads threads = threads_of(bodies, scene.solve.threads);
  const std::vector<const SceneBody*> said = bodies_of(scene);
  typename BodiesSystem<Real>::Bodies systems;
  typename BodiesSystem<Real>::Surfaces surfaces;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const auto& surface = surfaces.emplace_back(said[b]->contact_surface);
    systems.push_back(make_system<Real>(said[b]->model, *bodies[b],
                                        environment_of_body(scene.environment, surface), threads.each));
  }
  return std::make_unique<BodiesSystem<Real>>(std::move(systems), scene.environment, surfaces,
                                              threads.together);
}

template <class Real>
std::unique_ptr<SolidSystem<Real>> make_unreduced(const Scene& scene, const Body& body,
                                                  const RefinedBody* refined, const OtherBodies& others) {
  if (has_bodies_system(scene)) return make_several<Real>(scene, body, others);
  if (!refined)
    return make_system<Real>(scene.model, body, scene.environment, scene.solve.threads, scene.solve.sleep);
  return std::make_unique<RefinedSystem<Real>>(*refined, scene.environment,
                                               Execution{.threads = scene.solve.threads});
}

}  // namespace

std::unique_ptr<const RefinedBody> refined_body_of(const Scene& scene) {
  if (!scene.auto_refinement) return refined_body(scene);
  RefinementGoal goal{
      .levels = scene.auto_refinement->levels, .time = scene.solve.duration, .threads = scene.solve.threads};
  if (scene.auto_refinement->goal == AutoRefinement::Goal::displacement)
    for (const Expectation& e : scene.expectations)
      if (e.quantity == mean_displacement) goal.box = e.box;
  try {
    return std::make_unique<const RefinedBody>(scene.body,
                                               choose_refinement(scene.body, scene.environment, goal));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: body.refinement = \"auto\": {}", scene.file.string(), error.what()));
  }
}

OtherBodies other_bodies(const Scene& scene) {
  OtherBodies bodies;
  for (const SceneBody& other : scene.others) bodies.push_back(std::make_unique<const Body>(other.body));
  return bodies;
}

template <>
std::unique_ptr<SolidSystem<double>> make_solid(const Scene& scene, const Body& body,
                                                const RefinedBody* refined, const OtherBodies& others) {
  if (reduction_named(scene.model)) return make_reduced(scene, body);
  return make_unreduced<double>(scene, body, refined, others);
}
template <>
std::unique_ptr<SolidSystem<float>> make_solid(const Scene& scene, const Body& body,
                                               const RefinedBody* refined, const OtherBodies& others) {
  return make_unreduced<float>(scene, body, refined, others);
}

template <>
std::unique_ptr<BodySystem<double>> make_system(const std::string& model, const Body& body,
                                                const Environment& environment, int threads,
                                                const SleepRule& sleep) {
  check_model(model, body.config(), false);
  return find_model(model).make(body, environment, {.threads = threads, .sleep = sleep});
}

template <>
std::unique_ptr<BodySystem<float>> make_system(const std::string& model, const Body& body,
                                               const Environment& environment, int threads,
                                               const SleepRule& sleep) {
  check_model(model, body.config(), true);
  return std::make_unique<SpringSystem<float>>(body, environment,
                                               Execution{.threads = threads, .sleep = sleep});
}

}  // namespace mss
