#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/refinement/refined_system.hpp"
#include "core/scene/scene.hpp"
#include "core/springs/body_system.hpp"
#include "experiments/plot/chart.hpp"

namespace mss {

/// `fold_guard` of guarded bodies, k_g over the shear modulus: enough; at 10 one random state in some hundred
/// stays trapped.
inline constexpr double default_fold_guard = 20;

/// One line for each model: its name and summary.
std::vector<std::pair<std::string, std::string>> models();

/// The system of a body with a model; `threads` 0: as many as pay. The body must outlive it. Only springs
/// compute in single precision, and sleep. Throws InputError for an unknown model, and for finite elements
/// without elastic constants.
template <class Real>
std::unique_ptr<BodySystem<Real>> make_system(const std::string& model, const Body& body,
                                              const Environment& environment, int threads,
                                              const SleepRule& sleep = {});
template <>
std::unique_ptr<BodySystem<float>> make_system(const std::string& model, const Body& body,
                                               const Environment& environment, int threads,
                                               const SleepRule& sleep);
template <>
std::unique_ptr<BodySystem<double>> make_system(const std::string& model, const Body& body,
                                                const Environment& environment, int threads,
                                                const SleepRule& sleep);

/// The body of a scene with cells of several sizes, given or chosen; nullptr where it has one. Throws
/// InputError as choose_refinement() in integrators/analysis/chosen_refinement.hpp does.
std::unique_ptr<const RefinedBody> refined_body_of(const Scene& scene);

/// The bodies of a scene after the first.
using OtherBodies = std::vector<std::unique_ptr<const Body>>;
OtherBodies other_bodies(const Scene& scene);

/// The system of a scene: of its body, or of the refined one if that is given, or of all its bodies. They
/// must outlive it. Throws InputError where BodiesSystem does.
template <class Real>
std::unique_ptr<SolidSystem<Real>> make_solid(const Scene& scene, const Body& body,
                                              const RefinedBody* refined, const OtherBodies& others);
template <>
std::unique_ptr<SolidSystem<float>> make_solid(const Scene& scene, const Body& body,
                                               const RefinedBody* refined, const OtherBodies& others);
template <>
std::unique_ptr<SolidSystem<double>> make_solid(const Scene& scene, const Body& body,
                                                const RefinedBody* refined, const OtherBodies& others);

/// Throws InputError for an unknown name.
void check_model_name(const std::string& model);

/// Throws InputError if make_system() would.
void check_model(const std::string& model, const BodyConfig& body, bool single_precision);

/// Adds to a chart's subtitle what fills the bodies, if not springs.
void add_model_to_subtitle(Chart& chart, const std::string& model);

}  // namespace mss
