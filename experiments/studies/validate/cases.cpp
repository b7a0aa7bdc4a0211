// Cases and models of `mss validate`.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiments/harness/table.hpp"
#include "experiments/simulation/equilibrium.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/uniform_stress.hpp"
#include "experiments/studies/validate/validate.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/statics/linear_response.hpp"
#include "reference/calculix/calculix.hpp"
#include "reference/closed_forms.hpp"
#include "reference/fem/solid_law.hpp"

namespace mss::studies::validate {

namespace {

using std::numbers::pi;

/// [N]; the response is linear, so any load does: one that makes the rounding of springs at rest negligible.
constexpr double total_load = 1e5;

/// [Pa s]; damps the vibrations of the cube by one to two percent of critical.
constexpr double cube_viscosity = 100;

Box whole(const Vec3& upper) { return {Vec3::Zero(), upper}; }

/// The face of a box [0, upper] where the coordinate is 0, or where it is largest.
Box face(const Vec3& upper, int axis, bool far) {
  Box box = whole(upper);
  box.lower[axis] = box.upper[axis] = far ? upper[axis] : 0;
  return box;
}

Hold hold(const Box& box, const char* axes) {
  const std::string named = axes;
  const auto has = [&](char axis) { return named.find(axis) != std::string::npos; };
  return {.box = box, .axes = {has('x'), has('y'), has('z')}};
}

/// Work of the loads over the square of the total load [m/N].
Solution compliance(BodySystem<double>& system) {
  Work work;
  const LinearResponse r = linear_response(system, {}, work);
  return {r.status, inner(system, r.load, r.displacement) / (total_load * total_load)};
}

/// The same with the estimate of its error.
GoalEstimate estimated_compliance(BodySystem<double>& system) {
  Work work;
  const LinearResponse r = linear_response(system, {}, work);
  if (r.status != Status::ok) return {.status = r.status};
  GoalEstimate goal = GoalEstimator(system, r.displacement, work).displacement(r.load);
  goal.value /= total_load * total_load;
  goal.error /= total_load * total_load;
  return goal;
}

/// A cube under a uniform stress s, times total_load; `reference` is its compliance, s : C : s with C the
/// material's compliance tensor.
ValidationCase uniform_case(const std::string& name, const std::string& load, const Eigen::Matrix3d& stress,
                            double reference, const std::string& source) {
  return {.name = name,
          .description = "cube of 1 m, " + load,
          .quantity = "compliance",
          .unit = "m/N",
          .proportions = {1, 1, 1},
          .environment = uniform_stress(total_load * stress),
          .solve = compliance,
          .estimate = estimated_compliance,
          .reference = reference,
          .source = source,
          .charted = false,
          .most_cells = 4};
}

ValidationCase shear_case(double young) {
  Eigen::Matrix3d shear = Eigen::Matrix3d::Zero();
  shear(0, 1) = shear(1, 0) = 1;
  return uniform_case("shear", "sheared in the plane of two edges", shear, 2 * (1 + 0.3) / young, "1 / G");
}

/// Clamped at x = 0, sheared at the other end.
ValidationCase cantilever(double poisson) {
  const Vec3 size(4, 1, 1);
  const auto [value, uncertainty] = reference::calculix_value("cantilever", poisson, "deflection");
  return {.name = poisson == 0.3 ? "cantilever" : "cantilever_45",
          .description = "cantilever 4 x 1 x 1 m, its end clamped, sheared at its tip",
          .quantity = "deflection",
          .unit = "m/N",
          .poisson = poisson,
          .environment = {.holds = {hold(face(size, 0, false), "xyz")},
                          .loads = {{.box = face(size, 0, true), .force = {0, 0, total_load}}}},
          .solve = compliance,
          .estimate = estimated_compliance,
          .reference = value,
          .uncertainty = uncertainty,
          .source = "CalculiX C3D20"};
}

/// One end rotated about the axis by one radian, to first order; both ends are free to warp. The torque is
/// twice the stored energy.
ValidationCase torsion(double young) {
  const Vec3 size(4, 1, 1);
  const auto turned = [](const Vec3& rest) -> Vec3 {
    return rest[0] < 2 ? Vec3::Zero() : Vec3::UnitX().cross(rest - Vec3(0, 0.5, 0.5));
  };
  return {.name = "torsion",
          .description = "bar 4 x 1 x 1 m, twisted, its ends free to warp",
          .quantity = "torque per radian",
          .unit = "N m",
          .environment = {.holds = {hold(face(size, 0, false), "yz"), hold(face(size, 0, true), "yz"),
                                    hold({Vec3::Zero(), Vec3::Zero()}, "x")}},
          .solve =
              [=](BodySystem<double>& system) {
                Work work;
                const LinearResponse r = linear_response(system, turned, work);
                return Solution{r.status, inner(system, r.reaction, r.displacement)};
              },
          .estimate =
              [=](BodySystem<double>& system) {
                Work work;
                const LinearResponse r = linear_response(system, turned, work);
                if (r.status != Status::ok) return GoalEstimate{.status = r.status};
                GoalEstimate goal = GoalEstimator(system, r.displacement, work).stored_energy();
                goal.value *= 2;
                goal.error *= 2;
                return goal;
              },
          .reference = reference::torsion_stiffness({young, 0.3, 1, 4}),
          .source = "Saint-Venant"};
}

/// A quarter of a bar of 2 x 2 x 4 m that hangs from z = 4 m; x = 0 and y = 0 are planes of symmetry.
ValidationCase hanging(double young, double density) {
  constexpr double gravity = 9.81, poisson = 0.3;
  const Vec3 size(1, 1, 4);
  const auto paraboloid = [=](const Vec3& rest) -> Vec3 {
    const double squared = rest[0] * rest[0] + rest[1] * rest[1];
    return rest[2] < 2 ? Vec3::Zero() : Vec3(0, 0, density * gravity * poisson * squared / (2 * young));
  };
  const auto bottom = [](const Body& body) { return body.select(Vec3::Zero(), Vec3::Zero()).front(); };
  return {.name = "hanging",
          .description = "bar 2 x 2 x 4 m, hanging under its own weight",
          .quantity = "sag of its axis",
          .unit = "m",
          .poisson = poisson,
          .proportions = {1, 1, 4},
          .environment = {.gravity = {0, 0, -gravity},
                          .holds = {hold(face(size, 0, false), "x"), hold(face(size, 1, false), "y"),
                                    hold(face(size, 2, true), "z")}},
          .solve =
              [=](BodySystem<double>& system) {
                Work work;
                const LinearResponse r = linear_response(system, paraboloid, work);
                return Solution{r.status, -r.displacement.at(bottom(system.body()))[2]};
              },
          .estimate =
              [=](BodySystem<double>& system) {
                Work work;
                const LinearResponse r = linear_response(system, paraboloid, work);
                if (r.status != Status::ok) return GoalEstimate{.status = r.status};
                Field<double> weight(system.size());
                weight.set(bottom(system.body()), -Vec3::UnitZ());
                return GoalEstimator(system, r.displacement, work).displacement(weight);
              },
          .reference = reference::hanging_sag({young, poisson, 2, 4}, density, gravity),
          .source = "rho g L^2 / (2 E)"};
}

/// A vibration of a bar along x [Hz], with its modal momentum to the side and about the axis: a mode is
/// identified by its shape, not by its number.
struct Vibration {
  double frequency, sideways, turning;
};
std::vector<Vibration> vibrations(const BodySystem<double>& system, const Modes& found) {
  std::vector<Vibration> all;
  for (const Mode& mode : found.modes) {
    Vec3 moved = Vec3::Zero();
    double turned = 0;
    for (const std::ptrdiff_t site : system.particles()) {
      const Vec3 arm = system.body().rest_position(site) - Vec3(0, 0.5, 0.5), q = mode.shape.at(site);
      moved += system.mass(site) * q;
      turned += system.mass(site) * (arm[1] * q[2] - arm[2] * q[1]);
    }
    all.push_back({mode.omega / (2 * pi), std::hypot(moved[1], moved[2]), std::abs(turned)});
  }
  return all;
}

/// Frequency of the mode with the largest momentum about the axis, or of the n-th pair of bending modes:
/// those whose momentum to the side is at least a fifth of the largest.
double torsion_frequency(const std::vector<Vibration>& all) {
  return std::max_element(all.begin(), all.end(),
                          [](const Vibration& a, const Vibration& b) { return a.turning < b.turning; })
      ->frequency;
}
double bending_frequency(const std::vector<Vibration>& all, int pair) {
  double most = 0;
  for (const Vibration& v : all) most = std::max(most, v.sideways);
  int left = 2 * (pair - 1);
  for (const Vibration& v : all)
    if (v.sideways > most / 5 && left-- == 0) return v.frequency;
  return no_value;
}

/// One of the slowest vibrations of a clamped bar; `mode` is its number in CalculiX's tables.
ValidationCase vibration(const std::string& name, const std::string& what, int mode,
                         double (*pick)(const std::vector<Vibration>&)) {
  const auto [value, uncertainty] =
      reference::calculix_value("vibration", 0.3, "frequency_" + std::to_string(mode));
  return {.name = "vibration_" + name,
          .description = "cantilever 4 x 1 x 1 m, " + what,
          .quantity = "frequency",
          .unit = "Hz",
          .environment = {.holds = {hold(face({4, 1, 1}, 0, false), "xyz")}},
          .solve =
              [pick](BodySystem<double>& system) {
                constexpr int modes = 12;  // more than needed: anisotropic springs change their order
                Work work;
                const Modes found = slowest_modes(system, system.undeformed_state(), modes, work);
                if (found.status != Status::ok) return Solution{found.status, 0};
                return Solution{Status::ok, pick(vibrations(system, found))};
              },
          .reference = value,
          .uncertainty = uncertainty,
          .source = "CalculiX C3D20",
          .most_cells = 8};
}

/// Logarithmic decrement of a vibration: the body starts undeformed with velocities of a mode's shape, and
/// the mode's coordinate passes through zero in the same direction once a period.
Solution decrement(BodySystem<double>& system, const std::function<Vec3(const Vec3& rest)>& shape,
                   double period) {
  constexpr int periods = 2, steps_a_period = 800;
  constexpr double speed = 1e-5;  // [m/s]: strains of a millionth
  const State<double> start = system.undeformed_state();
  State<double> state = start;
  Field<double> mode = state.v;  // times the masses
  for (const std::ptrdiff_t site : system.particles()) {
    state.v.set(site, speed * shape(system.body().rest_position(site)));
    mode.set(site, system.mass(site) * state.v.at(site));
  }
  const IntegratorInfo& method = find_integrator("damped_verlet");
  const double dt = std::min(period / steps_a_period, 0.5 * guaranteed_step(method, system.spectral_bound()));
  const auto integrator = method.make<double>({.dt = dt});
  const double first = inner(system, mode, state.v);
  double moved = 0, rate = first;
  Work work;
  for (int seen = 0; state.t < 2 * periods * period;) {
    const double moved_before = moved, rate_before = rate;
    const Status status = integrator->advance(system, state, state.t + dt, work);
    if (status != Status::ok) return {status, 0};
    Field<double> u = state.x;
    u.array() -= start.x.array();
    moved = inner(system, mode, u);
    rate = inner(system, mode, state.v);
    if (!(moved_before < 0 && moved >= 0) || ++seen < periods) continue;
    const double share = moved_before / (moved_before - moved), angle = 2 * pi * dt / period;
    const double bulge = 1 + share * (1 - share) * angle * angle / 2;  // of a cosine over its chord
    return {Status::ok, std::log(first / (bulge * (rate_before + share * (rate - rate_before)))) / periods};
  }
  return {Status::ok, no_value};
}

/// A vibration along one axis of a viscous cube, whose end x = 0 is held and whose points move along no
/// other; viscosity and stiffness are those of its strain. The lattice makes a chain of it.
ValidationCase decay(const std::string& name, const std::string& what, int axis, double viscosity,
                     double stiffness, double density) {
  const Vec3 one = Vec3::Ones();
  const double frequency = reference::bar_frequency(stiffness, density, 1, 1);
  const auto shape = [axis](const Vec3& rest) -> Vec3 {
    return std::sin(pi / 2 * rest[0]) * Vec3::Unit(axis);
  };
  return {.name = "decay_" + name,
          .description =
              fmt::format("cube of 1 m of viscosity {:g} Pa s, one end held, {}", cube_viscosity, what),
          .quantity = "logarithmic decrement",
          .unit = "1",
          .viscosity = cube_viscosity,
          .proportions = {1, 1, 1},
          .environment = {.holds = {hold(face(one, 0, false), axis == 0 ? "x" : "y"),
                                    hold(whole(one), axis == 0 ? "yz" : "xz")}},
          .solve = [=](BodySystem<double>& system) { return decrement(system, shape, 1 / frequency); },
          .reference = reference::logarithmic_decrement(viscosity, stiffness, frequency),
          .source = "Kelvin-Voigt, zeta = viscosity omega / (2 stiffness)",
          .charted = false};
}

/// Shear, in which only eta acts, and uniaxial strain, to which Cauchy's relation gives 2 eta + lambda' = 3
/// eta.
ValidationCase shear_decay(double young, double density) {
  return decay("shear", "vibrating across", 1, cube_viscosity, lame_constants({young, 0.3}).mu, density);
}
ValidationCase longitudinal_decay(double young, double density) {
  const Lame lame = lame_constants({young, 0.3});
  return decay("longitudinal", "sides on rollers, vibrating along", 0, 3 * cube_viscosity,
               lame.lambda + 2 * lame.mu, density);
}

/// At equilibrium, the sum over the particles of the fixed end x = 2 of `of(position, reaction force)`.
Solution sum_of_reactions(BodySystem<double>& system, const std::function<Vec3(const Vec3& rest)>& guess,
                          const std::function<double(const Vec3& x, const Vec3& force)>& of) {
  const auto [status, state] = find_equilibrium(system, guess);
  if (status != Status::ok) return {status, 0};
  Field<double> force(system.size());
  system.force(1, state.x, state.v, force);
  double sum = 0;
  for (const std::ptrdiff_t site : system.body().select({2, 0, 0}, {2, 1, 1}))
    sum += of(state.x.at(site), -force.at(site));
  return {Status::ok, sum};
}

ValidationCase large_twist() {
  constexpr double angle = 60;
  const double rate = angle / 180 * pi;
  const Vec3 size(2, 1, 1), centre(0, 0.5, 0.5);
  Hold turning = hold(face(size, 0, true), "xyz");
  turning.turn = Turn{.axis = Vec3::UnitX(), .centre = centre, .rate = rate};
  const auto [value, uncertainty] = reference::calculix_value("twist", 0.3, "torque");
  return {.name = "large_twist",
          .description = "bar 2 x 1 x 1 m, both ends clamped, one rotated by 60 degrees",
          .quantity = "torque",
          .unit = "N m",
          .proportions = {2, 1, 1},
          .environment = {.holds = {hold(face(size, 0, false), "xyz"), turning}},
          .solve =
              [=](BodySystem<double>& system) {
                const auto guess = [=](const Vec3& rest) -> Vec3 {
                  return centre + Eigen::AngleAxisd(rate * rest[0] / 2, Vec3::UnitX()) * (rest - centre);
                };
                return sum_of_reactions(system, guess, [=](const Vec3& x, const Vec3& force) {
                  return (x - centre).cross(force)[0];
                });
              },
          .reference = value,
          .uncertainty = uncertainty,
          .source = "CalculiX C3D20, linear in Green's strain",
          .deformations = Deformations::large,
          .most_cells = 8};
}

ValidationCase large_compression() {
  constexpr double share = 0.2;
  const Vec3 size(2, 1, 1);
  Hold pushed = hold(face(size, 0, true), "xyz");
  pushed.displacement = {-share * size[0], 0, 0};
  const auto [value, uncertainty] = reference::calculix_value("compression", 0.3, "force");
  return {.name = "large_compression",
          .description = "bar 2 x 1 x 1 m, both ends clamped, shortened by 20 %",
          .quantity = "force",
          .unit = "N",
          .proportions = {2, 1, 1},
          .environment = {.holds = {hold(face(size, 0, false), "xyz"), pushed}},
          .solve =
              [=](BodySystem<double>& system) {
                const auto guess = [=](const Vec3& rest) -> Vec3 {
                  return {(1 - share) * rest[0], rest[1], rest[2]};
                };
                return sum_of_reactions(system, guess,
                                        [](const Vec3&, const Vec3& force) { return -force[0]; });
              },
          .reference = value,
          .uncertainty = uncertainty,
          .source = "CalculiX C3D20, linear in Green's strain",
          .deformations = Deformations::large,
          .most_cells = 8};
}

/// Springs in the thesis's proportions (k_e : k_f : k_c = 1 : 1 : 3, no volume force), scaled to have the
/// given Young's modulus along their edges; Poisson's ratio and anisotropy are what they are.
SpringConstants thesis_springs(const ElasticConstants& material, double cell_size) {
  const SpringConstants unit{.edge = 1, .face = 1, .body = 3, .volume = 0};
  const double scale = material.young / cubic_stiffness(unit, cell_size).young({1, 0, 0});
  return {.edge = scale, .face = scale, .body = 3 * scale, .volume = 0};
}

}  // namespace

ValidationCase tension_case(double young, const std::string& name, const Vec3& direction) {
  const Vec3 d = direction.normalized();
  return uniform_case(
      name, fmt::format("in tension along [{:g}{:g}{:g}]", direction[0], direction[1], direction[2]),
      d * d.transpose(), 1 / young, "1 / E");
}

std::vector<ValidationCase> validation_cases(double young, double density) {
  std::vector<ValidationCase> cases{
      cantilever(0.3),
      cantilever(0.45),
      torsion(young),
      hanging(young, density),
      vibration("bending", "its slowest bending vibration", 1,
                [](const auto& all) { return bending_frequency(all, 1); }),
      vibration("torsion", "its slowest vibration about its axis", 3, torsion_frequency),
      vibration("bending_2", "its second bending vibration", 4,
                [](const auto& all) { return bending_frequency(all, 2); }),
      large_twist(),
      large_compression()};
  cases.push_back(tension_case(young, "stretch_100", {1, 0, 0}));
  cases.push_back(tension_case(young, "stretch_110", {1, 1, 0}));
  cases.push_back(tension_case(young, "stretch_111", {1, 1, 1}));
  cases.push_back(shear_case(young));
  cases.push_back(shear_decay(young, density));
  cases.push_back(longitudinal_decay(young, density));
  return cases;
}

std::vector<ValidationModel> validation_models() {
  std::vector<ValidationModel> models{{"thesis's springs", spring_model, thesis_springs}};
  for (const double share : {0.25, 0.5, 1.0})
    models.push_back({fmt::format("springs, t = {:g}", share), spring_model,
                      [share](const ElasticConstants& m, double h) { return calibrate(m, h, share); }, true});
  const auto unused = [](const ElasticConstants& m, double h) { return calibrate(m, h, 0.5); };
  models.push_back({"elements, linear", "linear", unused});
  models.push_back({"elements, mean dilatation", "linear_mean_dilatation", unused});
  models.push_back({"elements, corotational", "corotational", unused, false, true});
  models.push_back({"elements, St. V.-Kirchhoff", "st_venant_kirchhoff", unused, false, true, true});
  return models;
}

}  // namespace mss::studies::validate
