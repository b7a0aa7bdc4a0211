#include "experiments/simulation/reduced_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiments/simulation/reduced_model.hpp"
#include "integrators/reduction/warped_motion.hpp"

namespace mss {

namespace {

/// Errors beyond these are several percent (`mss reduce`): linear shapes stretch what they bend, so that the
/// lattice stores much more there; a polynomial stores nearly the same, and so does a body that spins.
constexpr double most_lost = 0.1, most_excess_linear = 0.2, most_excess_nonlinear = 0.02, most_twist = 0.1,
                 most_deflection = 0.4;

int longest_axis(const Body& body) {
  const auto& cells = body.lattice().cells;
  return int(std::max_element(cells.begin(), cells.end()) - cells.begin());
}

double longest_side(const Body& body) {
  return body.config().cell_size * body.lattice().cells[std::size_t(longest_axis(body))];
}

}  // namespace

template <class Real>
ReducedWatch<Real>::ReducedWatch(SceneRun<Real>& run) : run_(run) {
  if constexpr (std::is_same_v<Real, double>) system_ = dynamic_cast<ReducedSystem*>(&run.system());
}

template <class Real>
double ReducedWatch<Real>::displacement() const {
  double most = 0;
  if constexpr (std::is_same_v<Real, double>)
    for (const std::ptrdiff_t site : system_->particles())
      most = std::max(most, (run_.state().x.at(site) - system_->rest_position(site)).norm());
  return most;
}

template <class Real>
double ReducedWatch<Real>::twist() const {
  if constexpr (std::is_same_v<Real, double>) {
    const Eigen::Index particles = Eigen::Index(system_->particles().size());
    const ParticleRows rows(*system_);
    const Eigen::MatrixXd moved =
        rows.from(run_.state().x, rows.count()) - rows.from(system_->rest_state().x, rows.count());
    const Eigen::MatrixXd curls = half_curls(system_->body(), moved);
    return curls.middleRows(longest_axis(system_->body()) * particles, particles).cwiseAbs().maxCoeff();
  }
  return 0;
}

template <class Real>
void ReducedWatch<Real>::add(const Measures& row, const Reactions& reactions) {
  if (!system_) return;
  if constexpr (std::is_same_v<Real, double>) {
    const double energy = row.elastic + row.volume_energy;
    const StoredEnergy lattice = system_->lattice().stored_energy(run_.state().x);
    most_energy_ = std::max(most_energy_, energy);
    most_excess_ = std::max(most_excess_, lattice.elastic + lattice.volume - energy);
    if (most_energy_ > 0) fit_.excess = most_excess_ / most_energy_;
    for (const std::vector<Vec3>& forces : {reactions.planes, reactions.obstacles})
      for (const Vec3& force : forces) fit_.touched = fit_.touched || !force.isZero(0);
    fit_.lost = system_->lost();
    if (system_->environment().holds.empty()) return;
    fit_.deflection = std::max(fit_.deflection, displacement() / longest_side(system_->body()));
    fit_.twist = std::max(fit_.twist, twist());
  }
}

template class ReducedWatch<float>;
template class ReducedWatch<double>;

std::vector<std::string> warnings_of(const Scene& scene, const ReducedFit& fit) {
  std::vector<std::string> warnings;
  const bool is_free = scene.environment.holds.empty();
  const bool is_cubic = reduction_named(scene.model) == Reduction::cubic;
  const std::string others = is_free || is_cubic ? "give material.model = \"springs\""
                                                 : "give material.model = \"modal_cubic\" or \"springs\"";
  if (fit.lost > most_lost)
    warnings.push_back(
        fmt::format("{:.2g} percent of the start, or of what an impulse gives, is no motion of {}'s shapes "
                    "and is lost; give more material.modes, or {}",
                    100 * fit.lost, scene.model, others));
  if (fit.excess > (is_free || is_cubic ? most_excess_nonlinear : most_excess_linear)) {
    const std::string how =
        is_free ? std::string("spinning or deforming that much")
                : fmt::format("bent by {:.2g} percent of its longest side", 100 * fit.deflection);
    warnings.push_back(
        fmt::format("{} is at its end: the lattice it stands for would store {:.3g} times the energy in the "
                    "body's shapes, {}; {}",
                    scene.model, 1 + fit.excess, how, others));
  } else if (is_cubic && fit.deflection > most_deflection) {
    warnings.push_back(fmt::format(
        "modal_cubic is at its end: the body moves by {:.2g} percent of its longest side, and "
        "its fast shapes, made heavy for longer steps, come late; give material.model = \"springs\"",
        100 * fit.deflection));
  }
  if (is_cubic && fit.twist > most_twist)
    warnings.push_back(fmt::format(
        "the body twists by {:.2g} degrees, which modal_cubic's shapes do not follow; give material.model = "
        "\"modal_warped\" or \"springs\"",
        fit.twist * 180 / std::numbers::pi));
  if (fit.touched)
    warnings.push_back(fmt::format(
        "a plane pushes the body, and {} has few shapes that give way there; give material.model = "
        "\"springs\", or more material.modes and compare",
        scene.model));
  return warnings;
}

}  // namespace mss
