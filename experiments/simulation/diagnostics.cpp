#include "experiments/simulation/diagnostics.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "core/body/material.hpp"
#include "experiments/simulation/scene_check.hpp"

namespace mss {

namespace {

bool in_fixed_steps(const Scene& scene) {
  return find_integrator(scene.solve.integrator).stepping == Stepping::fixed;
}

/// How many of the six rigid motions the holds leave, of particles at rest.
Eigen::Index free_motions(const Scene& scene, const std::vector<ParticleRecord>& particles) {
  using Motion = Eigen::Matrix<double, 6, 1>;
  const double reach = scene.body.cell_size *
                       Vec3(scene.body.voxels.nx(), scene.body.voxels.ny(), scene.body.voxels.nz()).norm();
  Eigen::Matrix<double, 6, 6> held = Eigen::Matrix<double, 6, 6>::Zero();
  for (const Hold& hold : scene.environment.holds)
    for (const ParticleRecord& p : particles) {
      const double margin = 1e-9 * scene.body.cell_size;
      if (!hold.surface && (((p.rest - hold.box.lower).array() < -margin).any() ||
                            ((p.rest - hold.box.upper).array() > margin).any()))
        continue;
      for (int axis = 0; axis < 3; ++axis) {
        if (!hold.axes[std::size_t(axis)]) continue;
        Motion motion;  // what it is held against
        motion << Vec3::Unit(axis), (p.rest - scene.body.origin).cross(Vec3::Unit(axis)) / reach;
        held += motion * motion.transpose();
      }
    }
  constexpr double none = 1e-9;
  const Motion shares = held.selfadjointView<Eigen::Lower>().eigenvalues();
  return (shares.array() <= none * std::max(shares.maxCoeff(), 1.0)).count();
}

/// What makes a method's steps more accurate.
std::string more_accurate(const Scene& scene) {
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  if (method.stepping == Stepping::adaptive) return "give a smaller solve.tolerance";
  if (method.springs_only) return "give more passes (solve.iterations), or a shorter solve.dt";
  if (scene.solve.iterations > 0 || method.name.find(':') != std::string::npos)
    return "give more solve.iterations, or a shorter solve.dt";
  if (method.implicit && method.order_undamped > 1)
    return "give a shorter solve.dt, or integrator = \"backward_euler\", which loses energy";
  return "give a shorter solve.dt, or another solve.integrator";
}

std::string on_gain(const Scene& scene, const EnergyGain& gain) {
  return fmt::format(
      "energy came from nowhere: at t = {:.4g} s the total is {:.3g} J above what the run began with and was "
      "given, {:.3g} percent of the {:.3g} J at play; {}",
      gain.t, gain.gained, 100 * gain.gained / gain.at_play, gain.at_play, more_accurate(scene));
}

std::string on_penetration(const Scene& scene, const Penetration& found) {
  const Plane& plane = scene.environment.planes[found.plane];
  const std::string depth = fmt::format("{:.3g} m, {:.3g} percent of a cell,", found.depth,
                                        100 * found.depth / scene.body.cell_size);
  const char* remedy =
      plane.contact == ContactLaw::impulse ? "a shorter solve.dt may help"
      : plane.contact == ContactLaw::thesis
          ? "that law leaves there what has passed; give contact = \"impulse\""
          : "its forces are too weak for this fall; give contact = \"impulse\", or smaller cells";
  if (found.ends_whole)
    return fmt::format("the whole body ends behind plane.{}, up to {} deep; unless it began there, {}",
                       found.plane, depth, remedy);
  return fmt::format("{} are up to {} behind plane.{} at t = {:.4g} s; {}",
                     found.of_vertices ? "vertices of the surface" : "particles", depth, found.plane, found.t,
                     remedy);
}

std::string on_imbalance(const Scene& scene, const Imbalance& imbalance) {
  const char* over = imbalance.over == Imbalance::Over::weight    ? "the body's weight and loads"
                     : imbalance.over == Imbalance::Over::inertia ? "those that accelerate it"
                                                                  : "those of its holds";
  return fmt::format(
      "steps are not solved: forces are out of balance by {:.3g} percent of {} at their ends, so that the "
      "body sags and moves as one of another material; {}",
      100 * imbalance.share, over, more_accurate(scene));
}

/// How long a wave of stretching takes from one end of the body's longest side to the other and back, in its
/// softest material [s]: the period of its slowest stretching. It may bend more slowly. 0 or not finite of
/// springs that do not resist every deformation.
double stretching_period(const Scene& scene) {
  const VoxelGrid& cells = scene.body.voxels;
  int axis = 0;
  const double length = scene.body.cell_size * Vec3(cells.nx(), cells.ny(), cells.nz()).maxCoeff(&axis);
  double slowest = std::numeric_limits<double>::infinity();
  for (const Part& part : scene.body.all_parts()) {
    const double young = part.elastic ? part.elastic->young : scene.body.young_of(part.springs, axis);
    slowest = std::min(slowest, std::sqrt(young / part.density));
  }
  return 2 * length / slowest;
}

/// Of steps that are stable, and too long for the body's vibrations or for a body of the usual units.
void add_step(const Scene& scene, double dt, std::vector<std::string>& diagnostics) {
  constexpr double usual = 0.05;  // [s]
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  if (method.stepping != Stepping::fixed || !std::isfinite(dt)) return;
  if (!scene.solve.dt && dt > usual && dt < scene.solve.duration)
    diagnostics.push_back(
        fmt::format("a step of {:.3g} s is safe, so the body is very large, soft or heavy: scenes are in "
                    "metres, kilograms and pascals; was it meant in millimetres or megapascals?",
                    dt));
  const double period = stretching_period(scene);
  constexpr double follows = 20;  // steps a period
  if (method.has_modulus && !method.limit && std::isnormal(period) && dt > period / 2)
    diagnostics.push_back(
        fmt::format("a step of {:.3g} s is {:.2g} times the period of the body's slowest stretching, {:.2g} "
                    "s: {} damps or shifts such vibrations and does not follow them; where they count give "
                    "solve.dt = {:.1g} or less",
                    dt, dt / period, period, method.name, period / follows));
}

/// Of bodies that contact may have lost.
void add_lost_contact(const SimulationResult& result, std::vector<std::string>& diagnostics) {
  constexpr double near_the_end = 0.95;  // of what contact follows
  if (!result.contact) return;
  if (result.contact->reach_so_far > near_the_end)
    diagnostics.push_back(fmt::format(
        "bodies are up to {:.2g} of a cell in each other, and from half a cell on contact lets go "
        "of them: they may have gone through; give a larger contact.stiffness, or slower or "
        "stiffer bodies",
        result.contact->depth_so_far));
  if (result.contact->motion_so_far > 1)
    diagnostics.push_back(
        fmt::format("bodies near each other moved by each other by {:.2g} of what contact follows in a step: "
                    "they may have gone through; give a shorter solve.dt",
                    result.contact->motion_so_far));
}

/// Of planes whose restitution was chosen and does nothing.
void add_lost_restitution(const Scene& scene, const SimulationResult& result,
                          std::vector<std::string>& diagnostics) {
  if (!result.rebounding_step) return;
  const std::vector<Plane>& planes = scene.environment.planes;
  for (std::size_t p = 0; p < planes.size(); ++p)
    if (planes[p].contact == ContactLaw::impulse && planes[p].restitution != Plane{}.restitution &&
        planes[p].restitution > 0)
      diagnostics.push_back(fmt::format(
          "plane.{}.restitution = {} has no effect: a step of {:.4g} s does not resolve the body's fastest "
          "motion, for which it had to be below about {:.2g} s; the body bounces by its springs alone",
          p, planes[p].restitution, result.dt, *result.rebounding_step));
}

/// Of what a run watched of itself.
void add_watched(const Scene& scene, const SimulationResult& result, std::vector<std::string>& diagnostics) {
  if (result.status == Status::non_finite) return;  // everything follows from that
  if (result.gain) diagnostics.push_back(on_gain(scene, *result.gain));
  for (const Penetration& found : result.penetrations) diagnostics.push_back(on_penetration(scene, found));
  if (result.imbalance && result.imbalance->share > StepBalance::tolerated)
    diagnostics.push_back(on_imbalance(scene, *result.imbalance));
  add_lost_restitution(scene, result, diagnostics);
  if (result.reduced)
    for (std::string& warning : warnings_of(scene, *result.reduced))
      diagnostics.push_back(std::move(warning));
}

/// Of a static scene that found no rest.
std::string on_holds(const Scene& scene, const SimulationResult& result) {
  if (scene.environment.holds.empty() && !scene.environment.planes.empty())
    return "nothing holds the body but planes, along which it may slide or turn freely; add a [[hold]]";
  if (scene.environment.holds.empty())
    return "nothing holds the body in place; where a scene has no [[hold]], few are at rest";
  if (!scene.environment.planes.empty()) return {};  // which may hold what the holds leave free
  const Eigen::Index motions = free_motions(scene, result.particles);
  if (motions == 0) return {};
  return fmt::format(
      "the holds leave {} of the body's 6 rigid motions free, so that it can move as a whole; hold more of "
      "it",
      motions);
}

}  // namespace

std::string diagnosis_of_divergence(const Scene& scene, double dt, const SureSteps& sure) {
  if (sure.free == 0)
    return fmt::format("no step of {} is sure to be stable here; choose another method",
                       scene.solve.integrator);
  if (!std::isfinite(sure.free)) return "the solution diverged; a shorter solve.dt may help";
  const std::string about =
      fmt::format("the {:.4g} s up to which small motions are sure to be stable", sure.free);
  if (dt > sure.free)
    return fmt::format("the step of {:.4g} s is longer than {}; give solve.dt = \"safe\", or less than that",
                       dt, about);
  if (sure.guarded < dt)
    return fmt::format(
        "the step of {:.4g} s is below {}, but where the fold guard acts up to {:.4g} s are; give such a "
        "solve.dt",
        dt, about, sure.guarded);
  return fmt::format(
      "the step of {:.4g} s is below {}, but the body deformed beyond small motions: a shorter "
      "solve.dt may help, or the body is too soft for its loads",
      dt, about);
}

std::vector<std::string> warnings_of_step(const Scene& scene, double dt) {
  std::vector<std::string> warnings;
  add_step(scene, dt, warnings);
  return warnings;
}

std::vector<std::string> diagnostics_of(const Scene& scene, const SimulationResult& result) {
  std::vector<std::string> diagnostics;
  if (result.status == Status::non_finite && in_fixed_steps(scene))
    diagnostics.push_back(diagnosis_of_divergence(scene, result.dt, result.sure_steps));
  if (result.status == Status::newton_stalled && is_static(scene))
    if (std::string diagnostic = on_holds(scene, result); !diagnostic.empty())
      diagnostics.push_back(std::move(diagnostic));
  const bool unsolved = result.status == Status::newton_stalled || result.status == Status::linear_stalled ||
                        result.status == Status::not_positive_definite;
  if (unsolved && in_fixed_steps(scene))
    diagnostics.push_back(
        fmt::format("a step's equations were not solved{}; give a shorter solve.dt, or another "
                    "solve.nonlinear_solver or solve.linear_solver",
                    scene.environment.planes.empty() ? "" : ", contact with planes among them"));
  if (result.status == Status::ok && !result.series.empty() && result.series.back().min_jacobian <= 0)
    diagnostics.push_back(fmt::format(
        "the body ends folded: the smallest signed volume at a cell's corner is {:.3g} of the one "
        "at rest (min_jacobian), and the largest stretch {:.3g}",
        result.series.back().min_jacobian, result.series.back().max_stretch));
  add_watched(scene, result, diagnostics);
  add_lost_contact(result, diagnostics);
  if (result.status == Status::ok) add_step(scene, result.dt, diagnostics);
  if (in_fixed_steps(scene) && result.work.steps > 1 && result.dt > (1 + 1e-9) * scene.solve.every)
    diagnostics.push_back(
        fmt::format("solve.every = {:.4g} s is less than the step of {:.4g} s: there is a row a step",
                    scene.solve.every, result.dt));
  if (scene.solve.local_steps && !result.in_local_steps)
    diagnostics.emplace_back("solve.local_steps saves nothing here: all cells take the same steps");
  return diagnostics;
}

}  // namespace mss
