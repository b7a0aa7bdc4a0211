// Speeds of the lattice's waves, and vibrations of bodies that are such waves.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/springs/spring_system.hpp"
#include "experiments/studies/lattice/lattice.hpp"
#include "integrators/integrator.hpp"

namespace mss::studies::lattice {

namespace {

using Eigen::Matrix3d;
constexpr double pi = std::numbers::pi;

constexpr double cell_size = 1;  ///< [m]
constexpr double density = 1;    ///< [kg/m^3]

const std::vector<std::pair<std::string, Vec3>>& named_directions() {
  static const std::vector<std::pair<std::string, Vec3>> all{
      {"[100]", {1, 0, 0}}, {"[110]", {1, 1, 0}}, {"[111]", {1, 1, 1}}};
  return all;
}

/// Over all directions; by the cube's symmetry those whose components descend.
std::pair<PhaseSpeeds, PhaseSpeeds> extreme_speeds(const LatticeMaterial& material, double cells,
                                                   int directions) {
  PhaseSpeeds least, most;
  least.fill(std::numeric_limits<double>::infinity());
  most.fill(0);
  for (int i = 0; i <= directions; ++i)
    for (int j = 0; j <= i; ++j) {
      const PhaseSpeeds speeds =
          phase_speeds(material, Vec3(1, double(i) / directions, double(j) / directions), cells);
      for (std::size_t k = 0; k < speeds.size(); ++k) {
        least[k] = std::min(least[k], speeds[k]);
        most[k] = std::max(most[k], speeds[k]);
      }
    }
  return {least, most};
}

/// A vibration of a cube of n cells between rollers, which mirror it to an infinite lattice: the sum of waves
/// along `direction` and its mirror images, each with the phase pi / n per cell along the axes that direction
/// has. Along an axis in which it is polarised it goes with the sine of the phase along that axis.
struct StandingWave {
  const char* name;
  WaveKind kind;
  Vec3 direction;            ///< components 0 or 1
  Vec3 polarisation;         ///< components 0, 1 or -1
  std::array<bool, 3> held;  ///< axes along which nothing moves; along others rollers hold the faces

  Vec3 displacement(const Vec3& phases) const {
    Vec3 u = polarisation;
    for (int axis = 0; axis < 3; ++axis)
      for (int along = 0; along < 3; ++along)
        if (direction[along] != 0)
          u[axis] *= axis == along ? std::sin(phases[along]) : std::cos(phases[along]);
    return u;
  }
};

const std::vector<StandingWave>& standing_waves() {
  static const std::vector<StandingWave> all{
      {"[100]", WaveKind::longitudinal, {1, 0, 0}, {1, 0, 0}, {false, true, true}},
      {"[110]", WaveKind::longitudinal, {1, 1, 0}, {1, 1, 0}, {false, false, true}},
      {"[111]", WaveKind::longitudinal, {1, 1, 1}, {1, 1, 1}, {false, false, false}},
      {"[100]", WaveKind::slow_shear, {1, 0, 0}, {0, 1, 0}, {true, false, true}},
      {"[110] along [001]", WaveKind::slow_shear, {1, 1, 0}, {0, 0, 1}, {true, true, false}},
      {"[110] along [1-10]", WaveKind::slow_shear, {1, 1, 0}, {1, -1, 0}, {false, false, true}},
      {"[111]", WaveKind::slow_shear, {1, 1, 1}, {1, -1, 0}, {false, false, false}}};
  return all;
}

/// Holds the axes in which the wave moves nothing, and rollers at the faces that it is mirrored at.
Environment rollers(const StandingWave& wave, double edge) {
  Environment environment;
  const Vec3 corner = Vec3::Constant(edge);
  environment.holds.push_back({.box = {Vec3::Zero(), corner}, .axes = wave.held});
  for (int axis = 0; axis < 3; ++axis) {
    if (wave.held[std::size_t(axis)] || wave.direction[axis] == 0) continue;
    std::array<bool, 3> axes{};
    axes[std::size_t(axis)] = true;
    Box lower{Vec3::Zero(), corner}, upper = lower;
    lower.upper[axis] = 0;
    upper.lower[axis] = edge;
    environment.holds.push_back({.box = lower, .axes = axes});
    environment.holds.push_back({.box = upper, .axes = axes});
  }
  return environment;
}

/// The frequency of a vibration that begins at rest in a shape, over an expected one: from its phase after a
/// quarter period more than ten.
struct MeasuredFrequency {
  Status status;
  double over_expected;
};
MeasuredFrequency measured_frequency(SpringSystem<double>& system, const StandingWave& wave, double phase,
                                     double omega) {
  constexpr double periods = 10.25, steps_per_period = 1000, amplitude = 1e-7;
  State<double> state = system.undeformed_state();
  Field<double> shape(system.size());
  for (const std::ptrdiff_t site : system.particles()) {
    const Vec3 rest = system.body().rest_position(site);
    shape.set(site, wave.displacement(phase * rest / cell_size));
    state.x.set(site, rest + amplitude * shape.at(site));
  }
  const double duration = periods * 2 * pi / omega, dt = duration / (periods * steps_per_period);
  Work work;
  const Status status =
      find_integrator("velocity_verlet").make<double>({.dt = dt})->advance(system, state, duration, work);
  double found = 0, whole = 0;
  for (const std::ptrdiff_t site : system.particles()) {
    const double mass = system.body().mass(site);
    found += mass * shape.at(site).dot(state.x.at(site) - system.body().rest_position(site));
    whole += mass * amplitude * shape.at(site).squaredNorm();
  }
  return {status, 1 - std::asin(found / whole) / (2 * pi * periods)};
}

}  // namespace

SpringConstants LatticeMaterial::springs() const {
  return calibrate({.young = 1, .poisson = poisson}, cell_size, face_share);
}

std::string LatticeMaterial::name() const { return fmt::format("nu = {:g}, t = {:g}", poisson, face_share); }

const char* to_string(WaveKind kind) {
  switch (kind) {
    case WaveKind::longitudinal:
      return "longitudinal";
    case WaveKind::slow_shear:
      return "slow shear";
    case WaveKind::fast_shear:
      return "fast shear";
  }
  return "";
}

PhaseSpeeds phase_speeds(const LatticeMaterial& material, const Vec3& direction,
                         double cells_per_wavelength) {
  const SpringConstants springs = material.springs();
  const CubicStiffness c = cubic_stiffness(springs, cell_size);
  const Vec3 along = direction.normalized(), phases = 2 * pi / cells_per_wavelength * along;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(
      wave_stiffness(springs, cell_size, Matrix3d::Identity(), phases));
  std::array<int, 3> order{0, 1, 2};  // eigenvalues ascend: of two shear waves the first is slower
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    constexpr double equal = 1e-9;
    return std::abs(eigen.eigenvectors().col(a).dot(along)) >
           std::abs(eigen.eigenvectors().col(b).dot(along)) + equal;
  });
  if (order[1] > order[2]) std::swap(order[1], order[2]);
  PhaseSpeeds speeds;
  for (std::size_t k = 0; k < speeds.size(); ++k) {
    const double modulus = k == 0 ? c.c11 : c.c44;
    // (omega / k)^2 = K / (rho h^3 k^2), of the continuum modulus / rho; |q| = k h.
    const double stiffness = std::max(eigen.eigenvalues()[order[k]], 0.0);
    speeds[k] = std::sqrt(stiffness / (phases.squaredNorm() * cell_size * modulus));
  }
  return speeds;
}

Table empty_dispersion() {
  return Table({{"poisson"},
                {"face_share"},
                {"wave"},
                {"direction"},
                {"cells_per_wavelength"},
                {"speed_over_continuum"},
                {"status"}});
}

Table empty_standing() {
  return Table({{"poisson"},
                {"face_share"},
                {"wave"},
                {"direction"},
                {"cells"},
                {"cells_per_wavelength"},
                {"frequency_over_continuum"},
                {"frequency_over_predicted"},
                {"status"}});
}

void add_dispersion(const LatticeConfig& config, const LatticeMaterial& material, Table& rows) {
  const auto add = [&](const std::string& direction, double cells, const PhaseSpeeds& speeds) {
    for (std::size_t k = 0; k < speeds.size(); ++k)
      rows.add({material.poisson, material.face_share, std::string(to_string(wave_kinds[k])), direction,
                cells, speeds[k], std::string(speeds[k] > 0 ? "ok" : "not resisted")});
  };
  for (const double cells : config.wavelengths) {
    for (const auto& [name, direction] : named_directions())
      add(name, cells, phase_speeds(material, direction, cells));
    const auto [slowest, fastest] = extreme_speeds(material, cells, config.directions);
    add("slowest", cells, slowest);
    add("fastest", cells, fastest);
  }
}

void add_standing_waves(const LatticeMaterial& material, int cells, Table& rows) {
  const SpringConstants springs = material.springs();
  const CubicStiffness c = cubic_stiffness(springs, cell_size);
  const Body body({.voxels = VoxelGrid::box(cells, cells, cells),
                   .cell_size = cell_size,
                   .density = density,
                   .springs = springs});
  const double phase = pi / cells;
  for (const StandingWave& wave : standing_waves()) {
    const Vec3 polarisation = wave.polarisation.normalized();
    const Matrix3d stiffness =
        wave_stiffness(springs, cell_size, Matrix3d::Identity(), phase * wave.direction);
    const double mass = density * cell_size * cell_size * cell_size;
    const double omega = std::sqrt(polarisation.dot(stiffness * polarisation) / mass);
    const double modulus = wave.kind == WaveKind::longitudinal ? c.c11 : c.c44;
    const double of_continuum = phase * wave.direction.norm() / cell_size * std::sqrt(modulus / density);
    SpringSystem<double> system(body, rollers(wave, cells * cell_size), {.threads = 1});
    const auto [status, over_expected] = measured_frequency(system, wave, phase, omega);
    rows.add({material.poisson, material.face_share,
              std::string(wave.kind == WaveKind::longitudinal ? "longitudinal" : "shear"),
              std::string(wave.name), cells, 2 * cells / wave.direction.norm(),
              over_expected * omega / of_continuum, over_expected,
              std::string(std::isfinite(over_expected) || status != Status::ok ? to_string(status)
                                                                               : "another frequency")});
  }
}

}  // namespace mss::studies::lattice
