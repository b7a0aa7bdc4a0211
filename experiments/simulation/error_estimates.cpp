#include "experiments/simulation/error_estimates.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "core/base/error.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "core/scene/scene_edit.hpp"
#include "experiments/simulation/model.hpp"
#include "integrators/statics/linear_response.hpp"

namespace mss {

namespace {

constexpr double negligible = 1e-3;  ///< of a component beside the others

/// A scene's body at rest, in cells of some size.
class AtRest {
 public:
  AtRest(const Scene& scene, const std::vector<ParticleRecord>& particles)
      : body_(scene.body),
        system_(make_system<double>(scene.model, body_, scene.environment, scene.solve.threads)),
        state_(system_->undeformed_state()) {
    state_.t = scene.solve.duration;
    for (std::size_t id = 0; id < particles.size(); ++id) state_.x.set(body_.sites()[id], particles[id].x);
  }
  const Body& body() const { return body_; }
  BodySystem<double>& system() { return *system_; }
  const State<double>& state() const { return state_; }

 private:
  Body body_;
  std::unique_ptr<BodySystem<double>> system_;
  State<double> state_;
};

/// One number that a state of rest has.
struct Goal {
  enum class Kind { displacement, reaction, energy };
  Kind kind;
  std::string quantity, unit;
  Field<double> weight{};  ///< of displacements, or of reactions at held coordinates
};

/// Equal weights of the particles, or of the mesh's vertices, in the box of an expectation.
Field<double> mean_over(const Scene& scene, const Body& body, const Expectation& e, const Vec3& direction) {
  Field<double> weight(body.lattice().size);
  if (!e.on_surface) {
    const std::vector<std::ptrdiff_t> sites = body.select(e.box.lower, e.box.upper);
    for (const std::ptrdiff_t site : sites) weight.set(site, direction / double(sites.size()));
    return weight;
  }
  const TriangleMesh mesh = scene.mesh->surface();
  const EmbeddedSurface surface(mesh, scene.body.voxels, scene.body.cell_size, scene.body.origin);
  const std::vector<std::size_t> vertices = vertices_in(mesh, e.box, 1e-9 * scene.body.cell_size);
  for (const std::size_t vertex : vertices)
    surface.distribute(vertex, direction / double(vertices.size()), weight);
  return weight;
}

/// 1 along an axis where a hold prescribes it; where holds overlap, the later one does.
Field<double> held_by(const Scene& scene, const Body& body, std::size_t hold, int axis) {
  Field<double> weight(body.lattice().size);
  const std::vector<Hold>& holds = scene.environment.holds;
  for (std::size_t i = hold; i < holds.size(); ++i) {
    if (!holds[i].axes[std::size_t(axis)]) continue;
    for (const std::ptrdiff_t site : sites_of(holds[i], body)) weight.axis(axis)[site] = i == hold ? 1 : 0;
  }
  return weight;
}

std::vector<Goal> goals_of(const Scene& scene, const Body& body) {
  constexpr const char* axes = "xyz";
  std::vector<Goal> goals;
  int number = 0;
  for (const Expectation& e : scene.expectations) {
    if (e.quantity != mean_displacement) continue;
    for (int axis = 0; axis < 3; ++axis)
      goals.push_back({Goal::Kind::displacement, fmt::format("displacement {} {}", number, axes[axis]), "m",
                       mean_over(scene, body, e, Vec3::Unit(axis))});
    ++number;
  }
  for (std::size_t hold = 0; hold < scene.environment.holds.size(); ++hold)
    for (int axis = 0; axis < 3; ++axis)
      goals.push_back({Goal::Kind::reaction, fmt::format("reaction of hold {} {}", hold, axes[axis]), "N",
                       held_by(scene, body, hold, axis)});
  goals.push_back({Goal::Kind::energy, "stored energy", "J", {}});
  return goals;
}

/// Of every goal, as the state has it.
std::vector<double> values_of(const Scene& scene, AtRest& at_rest) {
  BodySystem<double>& system = at_rest.system();
  const State<double>& state = at_rest.state();
  Field<double> force(system.size()), moved = state.x;
  system.force(state.t, state.x, state.v, force);
  moved.array() -= system.undeformed_state().x.array();
  const StoredEnergy stored = system.stored_energy(state.x);
  std::vector<double> values;
  for (const Goal& goal : goals_of(scene, at_rest.body()))
    values.push_back(goal.kind == Goal::Kind::displacement ? inner(system, goal.weight, moved)
                     : goal.kind == Goal::Kind::reaction   ? -inner(system, goal.weight, force)
                                                           : stored.elastic + stored.volume);
  return values;
}

/// Whether what the body stores is rounding of its particles' places: little beside what it would store at
/// twice its size, where strains are about 1.
bool is_undeformed(const Scene& scene, AtRest& at_rest) {
  BodySystem<double>& system = at_rest.system();
  const auto energy = [&](const Field<double>& x) {
    const StoredEnergy stored = system.stored_energy(x);
    return stored.elastic + stored.volume;
  };
  Field<double> twice = system.undeformed_state().x;
  twice.array() *= 2;
  const double rounding = scene.solve.precision == Precision::single
                              ? double(std::numeric_limits<float>::epsilon())
                              : std::numeric_limits<double>::epsilon();
  const double strain = 4 * rounding * twice.array().abs().maxCoeff() / scene.body.cell_size;
  return energy(at_rest.state().x) <= strain * strain * energy(twice);
}

GoalEstimate estimate(GoalEstimator& estimator, const Goal& goal) {
  return goal.kind == Goal::Kind::displacement ? estimator.displacement(goal.weight)
         : goal.kind == Goal::Kind::reaction   ? estimator.reaction(goal.weight)
                                               : estimator.stored_energy();
}

/// Whether boxes of a scene hold particles up to the same places in two bodies: otherwise a load or a goal is
/// another one in other cells.
bool same_boxes(const Scene& scene, const Body& a, const Body& b) {
  std::vector<Box> boxes;
  for (const Load& load : scene.environment.loads)
    if (!load.surface) boxes.push_back(load.box);
  for (const Expectation& e : scene.expectations)
    if (e.quantity == mean_displacement && !e.on_surface) boxes.push_back(e.box);
  const auto extent = [](const Body& body, const std::vector<std::ptrdiff_t>& sites) {
    Eigen::AlignedBox<double, 3> all;
    for (const std::ptrdiff_t site : sites) all.extend(body.rest_position(site));
    return all;
  };
  const auto same = [&](const auto& select) {
    return extent(a, select(a)).isApprox(extent(b, select(b)), 1e-9);
  };
  const std::vector<Hold>& holds = scene.environment.holds;
  return std::all_of(boxes.begin(), boxes.end(),
                     [&](const Box& box) {
                       return same([&](const Body& body) { return body.select(box.lower, box.upper); });
                     }) &&
         std::all_of(holds.begin(), holds.end(), [&](const Hold& hold) {
           return same([&](const Body& body) { return sites_of(hold, body); });
         });
}

/// Cells of a voxel file are the coarsest that a scene has, whatever they could make up.
std::string why_not_coarser(const Scene& scene) {
  if (scene.voxel_file.empty()) return "its cells do not make up whole ones of twice their size";
  return fmt::format("body.refine is {}; with twice that there are cells of twice their size to compare with",
                     level_of(scene));
}

/// Values of the goals in cells twice as large; throws InputError that says why there are none.
std::vector<double> coarser_values(const Scene& scene, const Body& body, Progress& progress) {
  SceneEdit edit = edit_of(scene);
  if (edit.level % 2 != 0) throw InputError(why_not_coarser(scene));
  edit.level /= 2;
  const Scene coarse = edited(scene, edit);
  if (!same_boxes(scene, body, Body(coarse.body)))
    throw InputError("a box of it holds particles at other places in cells of twice their size");
  const SimulationResult result = simulate(coarse, progress);
  if (result.status != Status::ok)
    throw InputError(fmt::format("in cells of twice their size it ends as {}", to_string(result.status)));
  AtRest at_rest(coarse, result.particles);
  return values_of(coarse, at_rest);
}

/// Components of vectors that are negligible.
void leave_out_negligible(std::vector<CorrectedValue>& values) {
  const auto vector_of = [](const CorrectedValue& v) { return v.quantity.substr(0, v.quantity.rfind(' ')); };
  std::vector<CorrectedValue> kept;
  for (const CorrectedValue& value : values) {
    double largest = 0;
    for (const CorrectedValue& other : values)
      if (vector_of(other) == vector_of(value)) largest = std::max(largest, std::abs(other.value));
    if (std::abs(value.value) > negligible * largest) kept.push_back(value);
  }
  values = std::move(kept);
}

void add_richardson(const Scene& scene, const Body& body, Progress& progress, SceneEstimates& estimates) {
  try {
    const std::vector<double> coarse = coarser_values(scene, body, progress);
    for (std::size_t i = 0; i < coarse.size(); ++i) {
      CorrectedValue& fine = estimates.values[i];
      fine.richardson = fine.value + (fine.value - coarse[i]) / 3;
    }
  } catch (const InputError& error) {
    estimates.no_richardson = error.what();
  }
}

}  // namespace

SceneEstimates estimate_errors(const Scene& scene, const std::vector<ParticleRecord>& particles,
                               Progress& progress) {
  SceneEstimates estimates;
  if (is_refined(scene)) {
    estimates.none = "an estimate of the error is of bodies with cells of one size";
    return estimates;
  }
  if (has_bodies_system(scene)) {
    estimates.none = "an estimate of the error is of one body that does not touch itself";
    return estimates;
  }
  if (!scene.body.is_solid()) {
    estimates.none = fmt::format("an estimate of the error is of cells of three dimensions, and this is {}",
                                 scene.body.noun());
    return estimates;
  }
  AtRest at_rest(scene, particles);
  try {
    Work work;
    GoalEstimator estimator(at_rest.system(), at_rest.state(), work);
    if (is_undeformed(scene, at_rest))
      throw InputError("nothing deforms the body: the energy that it stores is rounding");
    for (const Goal& goal : goals_of(scene, at_rest.body())) {
      const GoalEstimate found = estimate(estimator, goal);
      estimates.values.push_back({.quantity = goal.quantity,
                                  .unit = goal.unit,
                                  .value = found.value,
                                  .estimate = found.error,
                                  .doubts = found.doubts,
                                  .status = found.status});
    }
  } catch (const InputError& error) {
    estimates.none = error.what();
    return estimates;
  }
  add_richardson(scene, at_rest.body(), progress, estimates);
  leave_out_negligible(estimates.values);
  return estimates;
}

}  // namespace mss
