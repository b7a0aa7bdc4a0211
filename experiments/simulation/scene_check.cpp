#include "experiments/simulation/scene_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <tuple>

#include "core/base/error.hpp"
#include "core/device/device.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/reduced_model.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"
#include "integrators/position_based/position_based_integrator.hpp"

namespace mss {

namespace {

constexpr double most_rows = 1e9;

void check_safe(const IntegratorInfo& method) {
  if (method.stepping != Stepping::fixed) return;
  if (!method.limit)
    throw InputError(fmt::format(
        "dt = \"safe\" means nothing for {}, which is stable at any step; give dt in seconds", method.name));
  stable_step(method, {.omega = 1});  // throws if no step is safe
}

/// Adds the file and the table to the message of an error.
void check_table(const Scene& scene, const char* table, const std::function<void()>& check) {
  try {
    check();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}: {}", scene.file.string(), table, error.what()));
  }
}

/// A variant of a method says itself what other keys say.
void check_variant(const SolveConfig& solve) {
  const std::string& name = solve.integrator;
  if (solve.iterations != 0 && name.find(':') != std::string::npos)
    throw InputError(
        fmt::format("iterations = {} beside integrator = \"{}\"; give one of them", solve.iterations, name));
  if (solve.nonlinear_solver != SolveConfig{}.nonlinear_solver && name.find('/') != std::string::npos)
    throw InputError(fmt::format("nonlinear_solver = \"{}\" beside integrator = \"{}\"; give one of them",
                                 solve.nonlinear_solver, name));
}

/// Methods for springs, and what those that step springs one by one cannot do.
void check_springs(const Scene& scene, const IntegratorInfo& method) {
  if (!method.needs_springs()) return;
  if (scene.model != spring_model)
    throw InputError(
        fmt::format("{} is for model \"{}\", and material.model is \"{}\"; give another integrator",
                    method.name, spring_model, scene.model));
  if (method.springs_only && method.has_modulus) check_local_solutions(scene.body, method.name);
}

/// Collisions at the end of steps need a method of fixed step.
void check_contact(const Scene& scene, const IntegratorInfo& method) {
  if (method.collisions != Collisions::never) return;
  const auto check = [&](ContactLaw law) {
    if (law != ContactLaw::penalty)
      throw InputError(
          fmt::format("contact = \"{}\" acts in fixed steps, and {} has none; give contact = "
                      "\"penalty\", or another solve.integrator",
                      to_string(law), method.name));
  };
  for (const Plane& plane : scene.environment.planes) check(plane.contact);
  for (const Obstacle& obstacle : scene.environment.obstacles) check(obstacle.contact);
}

/// Where there are several bodies, or one that touches itself, "impulse" is a law of particles.
void check_touching_meshes(const Scene& scene) {
  const std::vector<const SceneBody*> bodies = bodies_of(scene);
  if (!has_bodies_system(scene) || std::none_of(bodies.begin(), bodies.end(), [](const SceneBody* one) {
        return one->contact_surface != nullptr;
      }))
    return;
  const auto check = [](const char* table, std::size_t number, ContactLaw law) {
    if (law == ContactLaw::impulse)
      throw InputError(fmt::format(
          "{}.{}.contact = \"impulse\" touches particles where there are several bodies, or one that touches "
          "itself, and body.contact_on is \"surface\"; give contact = \"penalty\", or contact_on = "
          "\"particles\"",
          table, number));
  };
  const auto& [planes, obstacles] = std::tie(scene.environment.planes, scene.environment.obstacles);
  for (std::size_t i = 0; i < planes.size(); ++i) check("plane", i, planes[i].contact);
  for (std::size_t i = 0; i < obstacles.size(); ++i) check("obstacle", i, obstacles[i].contact);
}

/// Local steps take the place of a step's only force.
void check_local_steps(const Scene& scene, const IntegratorInfo& method) {
  if (!scene.solve.local_steps) return;
  if (!is_refined(scene))
    throw InputError(
        "local_steps is for bodies with cells of several sizes; leave it out, or give [[refine]]");
  if (method.local_steps) return;
  std::vector<std::string> allowed;
  for (const IntegratorInfo& info : integrators())
    if (info.local_steps) allowed.push_back(info.name);
  throw InputError(
      fmt::format("local_steps is for {}, and integrator is \"{}\"; leave it out, or give one of these",
                  fmt::join(allowed, ", "), method.name));
}

/// What needs one lattice for the whole body.
void check_refined(const Scene& scene, const IntegratorInfo& method) {
  if (!is_refined(scene)) return;
  const char* given = scene.auto_refinement ? "body.refinement" : "[[refine]]";
  const auto refuse = [&](std::string_view what, std::string_view name, std::string_view others) {
    throw InputError(fmt::format("{} '{}' is for bodies with cells of one size; leave {} out, or give {}",
                                 what, name, given, others));
  };
  if (method.needs_springs()) refuse("integrator", method.name, "another one");
  const SolveConfig& solve = scene.solve;
  if (find_linear_solver(solve.linear_solver).one_lattice)
    refuse("linear solver", solve.linear_solver, "\"cholmod\" or \"matrix_free\"");
  if (solve.sleep.bound > 0)
    throw InputError(fmt::format("sleep is for bodies with cells of one size; leave it or {} out", given));
}

/// What takes a body as cells of three dimensions: linear solvers of one lattice coarsen or diagonalise it,
/// nonlinear ones other than Newton's turn its cells.
void check_dimensions(const Scene& scene, const IntegratorInfo& method) {
  if (scene.body.is_solid() || !method.implicit) return;
  const auto refuse = [&](std::string_view what, std::string_view name, std::string_view others) {
    throw InputError(fmt::format("{} '{}' is for cells of three dimensions, and body.cells make {}; give {}",
                                 what, name, scene.body.noun(), others));
  };
  const SolveConfig& solve = scene.solve;
  if (find_linear_solver(solve.linear_solver).one_lattice)
    refuse("linear solver", solve.linear_solver, "\"cholmod\" or \"matrix_free\"");
  const std::string& nonlinear =
      method.nonlinear_solver.empty() ? solve.nonlinear_solver : method.nonlinear_solver;
  if (nonlinear != SolveConfig{}.nonlinear_solver) refuse("nonlinear solver", nonlinear, "\"newton\"");
}

/// What takes one body by itself, where several may touch, or one itself.
void check_bodies(const Scene& scene, const IntegratorInfo& method) {
  if (!has_bodies_system(scene)) return;
  const char* given = scene.others.empty() ? "[contact]" : "[[body]]";
  const auto refuse = [&](const std::string& what) {
    throw InputError(
        fmt::format("{} is for one body that does not touch itself, and the scene has {}; give "
                    "another one, or leave it out",
                    what, given));
  };
  const SolveConfig& solve = scene.solve;
  if (method.needs_springs()) refuse(fmt::format("integrator '{}'", method.name));
  if (method.stepping == Stepping::reduced) refuse(fmt::format("integrator '{}'", method.name));
  if (method.implicit && find_linear_solver(solve.linear_solver).one_lattice)
    refuse(fmt::format("linear solver '{}'", solve.linear_solver));
  const std::string& nonlinear =
      method.nonlinear_solver.empty() ? solve.nonlinear_solver : method.nonlinear_solver;
  if (method.implicit && nonlinear != SolveConfig{}.nonlinear_solver)
    refuse(fmt::format("nonlinear solver '{}'", nonlinear));
  if (is_refined(scene)) refuse(scene.auto_refinement ? "body.refinement" : "[[refine]]");
  if (solve.sleep.bound > 0) refuse("sleep");
  if (solve.device != SolveConfig{}.device) refuse(fmt::format("device '{}'", solve.device));
  for (const SceneBody* one : bodies_of(scene))
    if (reduction_named(one->model)) refuse(fmt::format("model '{}'", one->model));
}

/// Sleeping particles have no acceleration, but other methods evaluate forces on all of them.
void check_sleep(const Scene& scene, const IntegratorInfo& method) {
  if (scene.solve.sleep.bound == 0) return;
  if (scene.model != spring_model)
    throw InputError(fmt::format("sleep is for model \"{}\", and material.model is \"{}\"; leave it out",
                                 spring_model, scene.model));
  if (method.implicit || method.springs_only || method.stepping != Stepping::fixed)
    throw InputError(fmt::format(
        "sleep is for explicit methods of fixed step, and {} is none; leave it out, or give another "
        "integrator",
        method.name));
  for (const Load& load : scene.environment.loads)
    if (!load.history.empty())
      throw InputError(
          "sleep is for constant loads, whose forces wake nothing; leave it out, or leave load.history out");
}

}  // namespace

void check_model(const Scene& scene) {
  if (scene.modes > 0 && !reduction_named(scene.model))
    throw InputError(
        fmt::format("{}: material: modes = {} is of models that reduce the body, and model is \"{}\"; leave "
                    "it out, or give "
                    "\"modal\", \"modal_warped\" or \"modal_cubic\"",
                    scene.file.string(), scene.modes, scene.model));
  if (scene.match)
    throw InputError(fmt::format(
        "{}: body.match changes moduli, which was not done here; leave it out, or give the moduli "
        "that `mss run` prints",
        scene.file.string()));
  const bool single = scene.solve.precision == Precision::single;
  check_table(scene, "material", [&] {
    for (const SceneBody* one : bodies_of(scene)) check_model(one->model, one->body, single);
  });
}

bool is_static(const Scene& scene) {
  return find_integrator(scene.solve.integrator).stepping == Stepping::equilibrium;
}

void check_shared(const Scene& scene) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(
        fmt::format("{}: {} is for a body in one process; leave it out, or start mss without mpirun",
                    scene.file.string(), what));
  };
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  if (method.stepping == Stepping::equilibrium || method.needs_springs() ||
      method.linear_algebra == LinearAlgebra::own_factors)
    refuse(fmt::format("integrator = \"{}\"", method.name));
  const bool by_newton =
      scene.solve.nonlinear_solver == SolveConfig{}.nonlinear_solver && method.nonlinear_solver.empty();
  if (method.implicit && !by_newton) refuse("a nonlinear solver other than \"newton\"");
  if (method.implicit && method.linear_algebra == LinearAlgebra::chosen &&
      !find_linear_solver(scene.solve.linear_solver).in_ranks)
    throw InputError(
        fmt::format("{}: {} in ranks needs linear_solver = \"matrix_free\", and that is \"{}\"; give it, or "
                    "start mss without mpirun",
                    scene.file.string(), method.name, scene.solve.linear_solver));
  if (scene.model != spring_model) refuse(fmt::format("model \"{}\"", scene.model));
  if (is_refined(scene)) refuse(scene.auto_refinement ? "body.refinement" : "[[refine]]");
  if (has_bodies_system(scene)) refuse(scene.others.empty() ? "[contact]" : "[[body]]");
  if (scene.solve.sleep.bound > 0) refuse("sleep");
  if (scene.solve.device != SolveConfig{}.device) refuse("solve.device");
  if (scene.environment.contact_surface) refuse("contact_on = \"surface\"");
  const auto acts_on_surface = [](const auto& action) { return action.surface != nullptr; };
  const auto& [holds, loads] = std::tie(scene.environment.holds, scene.environment.loads);
  if (std::any_of(holds.begin(), holds.end(), acts_on_surface)) refuse("a hold of a mesh's faces");
  if (std::any_of(loads.begin(), loads.end(), acts_on_surface)) refuse("a load on a mesh's vertices");
}

void check_one_body(const Scene& scene, const std::string& what) {
  if (has_bodies_system(scene))
    throw InputError(fmt::format("{}: {} is for one body that does not touch itself, and the scene has {}",
                                 scene.file.string(), what,
                                 scene.others.empty() ? "[contact] with self = true; give self = false"
                                                      : "several [[body]]; give one of them alone"));
}

void check_solve(const Scene& scene) {
  const bool single = scene.solve.precision == Precision::single;
  check_model(scene);
  check_table(scene, "solve", [&] {
    const IntegratorInfo& method = find_integrator(scene.solve.integrator);
    if (method.springs_only && !method.has_modulus) check_regions(scene.body, method.name);
    if (!scene.solve.dt) check_safe(method);
    if (single && !method.make_single)
      throw InputError(fmt::format(
          "integrator '{}' computes in double precision only; give precision = \"double\"", method.name));
    find_linear_solver(scene.solve.linear_solver);
    find_nonlinear_solver(scene.solve.nonlinear_solver);
    check_variant(scene.solve);
    check_sleep(scene, method);
    check_springs(scene, method);
    check_refined(scene, method);
    check_dimensions(scene, method);
    check_local_steps(scene, method);
    check_bodies(scene, method);
    if (scene.solve.device != SolveConfig{}.device) Device::open(scene.solve.device);
  });
  check_table(scene, "plane", [&] { check_contact(scene, find_integrator(scene.solve.integrator)); });
  check_table(scene, "contact", [&] { check_touching_meshes(scene); });
  if (scene.solve.dt && *scene.solve.dt > scene.solve.duration)
    throw InputError(
        fmt::format("{}: solve.dt = {} s is longer than solve.duration = {} s; give a shorter step",
                    scene.file.string(), *scene.solve.dt, scene.solve.duration));
  if (scene.solve.duration / scene.solve.every > most_rows)
    throw InputError(fmt::format(
        "{}: solve.every = {} s makes more than {:.0e} rows of solve.duration = {} s; give a longer interval",
        scene.file.string(), scene.solve.every, most_rows, scene.solve.duration));
}

}  // namespace mss
