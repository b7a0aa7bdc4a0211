// Strains at which the lattice loses its stability, and bodies stepped beside them.
#include <algorithm>
#include <cmath>
#include <random>

#include "core/springs/spring_system.hpp"
#include "experiments/studies/lattice/lattice.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/integrator.hpp"

namespace mss::studies::lattice {

namespace {

constexpr double cell_edge = 1;       ///< [m]
constexpr double left = 1e3;          ///< times the first disturbance: a body does not stay where it was
constexpr double far = 1e5;           ///< the same, beyond which it is not followed
constexpr double crossings = 100;     ///< of a body by a shear wave, for which it is followed
constexpr double disturbance = 1e-6;  ///< of a cell

/// What holds a cube that is stretched along x, by a gradient whose axes are the cells'.
enum class Sides {
  rollers,  ///< at all faces: they are mirrors, so that motions are those waves of the lattice that fit
  free      ///< plates without friction at the ends alone
};

Environment strained_rollers(const Eigen::Matrix3d& F, double edge, Sides sides) {
  Environment environment;
  for (int axis = 0; axis < (sides == Sides::free ? 1 : 3); ++axis)
    for (const bool is_upper : {false, true}) {
      Hold hold{.box = {Vec3::Zero(), Vec3::Constant(edge)}, .axes = {axis == 0, axis == 1, axis == 2}};
      if (is_upper) {
        hold.box.lower[axis] = edge;
        hold.displacement[axis] = (F(axis, axis) - 1) * edge;
      } else {
        hold.box.upper[axis] = 0;
      }
      environment.holds.push_back(hold);
    }
  return environment;
}

/// The strain that a body is given beside its limit: beyond it with the sides where they were last at rest.
Eigen::Matrix3d gradient_beside(const SpringConstants& springs, const PhononLimit& limit, double strain) {
  constexpr double before = 2e-4;  // twice the limit's error
  const bool no_rest = limit.is_of_sides() && strain > limit.strain;
  Eigen::Matrix3d F =
      strained_gradient(springs, cell_edge, limit.path, no_rest ? limit.strain - before : strain);
  F(0, 0) = limit.path.kind == StrainPath::Kind::tension ? 1 + strain : 1 - strain;
  return F;
}

struct Growth {
  Status status = Status::ok;
  double factor = 0;  ///< largest distance from the uniform strain over the first, root mean squares
};

Growth growth(const SpringConstants& springs, int cells, const Eigen::Matrix3d& F, Sides sides) {
  constexpr double density = 1;
  const double edge = cells * cell_edge;
  const Body body({.voxels = VoxelGrid::box(cells, cells, cells),
                   .cell_size = cell_edge,
                   .density = density,
                   .springs = springs});
  SpringSystem<double> system(body, strained_rollers(F, edge, sides), {.threads = 1});
  State<double> state = system.undeformed_state();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-disturbance * cell_edge, disturbance * cell_edge);
  for (const std::ptrdiff_t site : system.particles()) state.x.set(site, F * body.rest_position(site));
  const Field<double> strained = state.x;
  for (const std::ptrdiff_t site : system.particles())
    state.x.set(site, strained.at(site) + Vec3(uniform(random), uniform(random), uniform(random)));
  system.constrain(0, state.x, state.v);
  const auto distance = [&] { return (state.x.array() - strained.array()).matrix().norm(); };
  const double first = distance(), shear_speed = std::sqrt(cubic_stiffness(springs, cell_edge).c44 / density);
  const IntegratorInfo& method = find_integrator("velocity_verlet");
  const auto integrator =
      method.make<double>({.dt = safe_share / 2 * stable_step(method, system.spectral_bound())});
  Growth grown;
  Work work;
  for (int i = 1; i <= crossings && grown.factor < far; ++i) {
    grown.status = integrator->advance(system, state, i * edge / shear_speed, work);
    if (grown.status != Status::ok) break;
    grown.factor = std::max(grown.factor, distance() / first);
  }
  return grown;
}

}  // namespace

Table empty_limits() {
  return Table({{"poisson"},
                {"face_share"},
                {"path"},
                {"strain"},
                {"wave_x", "rad"},
                {"wave_y", "rad"},
                {"wave_z", "rad"},
                {"status"}});
}

Table empty_growth() {
  return Table({{"poisson"},
                {"face_share"},
                {"path"},
                {"sides"},
                {"limit"},
                {"strain_over_limit"},
                {"strain"},
                {"cells"},
                {"growth"},
                {"outcome"},
                {"status"}});
}

void add_limits(const LatticeMaterial& material, Table& rows) {
  for (const StrainPath& path : strain_paths()) {
    const PhononLimit limit = phonon_limit(material.springs(), cell_edge, path, farthest_strain);
    const Vec3& q = limit.wave.phases;
    const bool found = std::isfinite(limit.strain), grows = found && !limit.is_of_sides();
    rows.add({material.poisson, material.face_share, path.name(), found ? limit.strain : no_value,
              grows ? q[0] : no_value, grows ? q[1] : no_value, grows ? q[2] : no_value,
              std::string(grows   ? "ok"
                          : found ? "free sides give way"
                                  : "stable up to 0.9")});
  }
}

void add_growth(const LatticeMaterial& material, int cells, Table& rows) {
  const SpringConstants springs = material.springs();
  for (const auto kind : {StrainPath::Kind::tension, StrainPath::Kind::compression}) {
    const PhononLimit limit = phonon_limit(springs, cell_edge, {kind}, farthest_strain);
    if (!std::isfinite(limit.strain)) continue;
    for (const Sides sides : {Sides::rollers, Sides::free}) {
      if (sides == Sides::rollers && limit.is_of_sides()) continue;
      for (const double share : {0.5, 0.7, 0.8, 0.9, 0.98, 1.02, 1.1}) {
        const double strain = share * limit.strain;
        const auto [status, factor] = growth(springs, cells, gradient_beside(springs, limit, strain), sides);
        rows.add({material.poisson, material.face_share, limit.path.name(),
                  std::string(sides == Sides::free ? "free" : "rollers"), limit.strain, share, strain, cells,
                  status == Status::ok ? factor : no_value,
                  std::string(status != Status::ok ? "explodes"
                              : factor > left      ? "leaves"
                                                   : "stays"),
                  std::string(to_string(status))});
      }
    }
  }
}

}  // namespace mss::studies::lattice
