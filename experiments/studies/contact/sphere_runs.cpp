// Elastic spheres pressed on a plane and on each other, and thrown at a plane, beside Hertz's theory and the
// finite sphere.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/scene.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/studies/contact/sphere.hpp"
#include "experiments/studies/contact/touching.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::contact {

namespace {

constexpr double radius = 0.5;                                   // [m]
constexpr ElasticConstants elastic{1e6, 0.3};                    // [Pa]
constexpr double sphere_density = 1000;                          // [kg/m^3]
constexpr std::array approaches{0.005, 0.01, 0.02, 0.03, 0.04};  // over the radius

double c_of_sphere() { return std::sqrt(elastic.young / sphere_density); }
double cell_of(int cells) { return 2 * radius / cells; }

/// 20 n^2 triangles whose edges are about a cell long; n is even, so that poles are vertices.
TriangleMesh sphere_mesh(int cells) { return icosphere(radius, 2 * int(std::lround(0.3 * cells))); }

/// Which part of a sphere about the origin.
enum class Half { lower, upper, both };

BodyConfig sphere_body(int cells, Half half, const Vec3& centre = Vec3::Zero()) {
  const MeshFill fill = fill_mesh(sphere_mesh(cells), {.cell_size = cell_of(cells)});
  const int layers = fill.voxels.nz(), first = half == Half::upper ? layers / 2 : 0;
  VoxelGrid part(fill.voxels.nx(), fill.voxels.ny(), half == Half::both ? layers : layers / 2);
  std::vector<std::uint32_t> content_of(part.boxed());
  part.for_each_place([&](int i, int j, int k) {
    part.set(i, j, k, fill.voxels.at(i, j, k + first));
    content_of[part.index(i, j, k)] = fill.content_of[fill.voxels.index(i, j, k + first)];
  });
  BodyConfig config{.voxels = std::move(part),
                    .contents = fill.contents,
                    .content_of = std::move(content_of),
                    .cell_size = fill.cell_size,
                    .origin = fill.origin + centre + Vec3(0, 0, first * fill.cell_size),
                    .density = sphere_density};
  config.fill(elastic, 0.5);
  return config;
}

/// The part of a sphere's surface that may touch, about a pole, turned about its axis.
std::shared_ptr<const TriangleMesh> cap(int cells, Half half, const Vec3& centre = Vec3::Zero(),
                                        double turn = 0) {
  constexpr double lowest = 0.85;  // of the radius from the centre
  const TriangleMesh whole = sphere_mesh(cells);
  TriangleMesh part;
  std::vector<int> number(whole.vertices.size(), -1);
  const Eigen::AngleAxisd about_axis(turn, Vec3::UnitZ());
  const auto is_outside = [&](int vertex) {
    const double z = whole.vertices[std::size_t(vertex)][2];
    return (half == Half::upper ? z : -z) < lowest * radius;
  };
  for (std::array<int, 3> triangle : whole.triangles) {
    if (std::any_of(triangle.begin(), triangle.end(), is_outside)) continue;
    for (int& vertex : triangle) {
      int& known = number[std::size_t(vertex)];
      if (known < 0) {
        known = int(part.vertices.size());
        part.vertices.push_back(about_axis * whole.vertices[std::size_t(vertex)] + centre);
      }
      vertex = known;
    }
    part.triangles.push_back(triangle);
  }
  return std::make_shared<const TriangleMesh>(std::move(part));
}

/// Holds the equator's height, moved by so much, and its middle.
void hold_equator(double z, double by, std::vector<Hold>& holds) {
  constexpr double thin = 1e-6, far = 10 * radius;
  holds.push_back({.box = {{-far, -far, z - thin}, {far, far, z + thin}},
                   .axes = {false, false, true},
                   .displacement = {0, 0, by}});
  holds.push_back({.box = {{-thin, -thin, z - thin}, {thin, thin, z + thin}}, .axes = {true, true, false}});
}

void move(const std::vector<Level>& levels, std::size_t body, double by, State<double>& state) {
  const Level& level = levels[body];
  for (const std::ptrdiff_t own : level.body.sites())
    state.x.set(level.first + own, state.x.at(level.first + own) + Vec3(0, 0, by));
}

/// Until it is at rest: damped critically at about the lowest frequency, that of a quarter wave along the
/// radius.
Status settle(SolidSystem<double>& system, State<double>& state) {
  constexpr double times = 9;  // R / c
  const IntegratorInfo& info = find_integrator("verlet");
  const double dt = safe_share * stable_step(info, system.spectral_bound()),
               slowest = std::numbers::pi / 2 * c_of_sphere() / radius;
  const auto method = info.make<double>({.dt = dt});
  Work work;
  state.t = 0;
  state.v.array() = 0;
  while (state.t < times * radius / c_of_sphere()) {
    const Status status = method->advance(system, state, state.t + dt, work);
    if (status != Status::ok) return status;
    state.v.array() *= std::exp(-2 * slowest * dt);
    method->reset();
  }
  return Status::ok;
}

/// How a body is pressed.
struct Pressing {
  Status status = Status::ok;
  double force = 0;   ///< [N]
  double moment = 0;  ///< sum of p r^2 over what presses [N m^2]
};

/// By the forces of springs on the particles off the equator, which what they touch balances. Particles are
/// farther from the axis than the vertices that touch: by the weights of a vertex by h^2 / 3 in the mean of
/// its places in a cell.
Pressing by_springs(SpringSystem<double>& springs, const State<double>& state) {
  Pressing pressing;
  Field<double> force(springs.size());
  springs.force(0, state.x, state.v, force);
  const double h = springs.body().config().cell_size;
  for (const std::ptrdiff_t site : springs.particles()) {
    if (springs.body().rest_position(site)[2] > -h / 2) continue;
    const Vec3 x = state.x.at(site);
    const double pressure = -force.at(site)[2];
    pressing.force += pressure;
    pressing.moment += pressure * (x[0] * x[0] + x[1] * x[1] - h * h / 3);
  }
  return pressing;
}

/// Calls add(approach, pressing) for each approach.
template <class Add>
void press_on_plane(const PressRun& run, Add&& add) {
  const Body body(sphere_body(run.cells, Half::lower));
  SpringSystem<double> springs(body, {}, {.threads = 1});
  State<double> state = springs.rest_state();
  const ContactLaw law = run.on == PressedOn::impulse ? ContactLaw::impulse : ContactLaw::penalty;
  double before = 0;
  for (const double approach : approaches) {
    if (approach > run.deepest) break;
    Environment environment{.planes = {{.point = {0, 0, -radius},
                                        .contact = law,
                                        .restitution = law == ContactLaw::impulse ? 0.0 : 1.0,
                                        .friction = 0}},
                            .contact_surface = cap(run.cells, Half::lower)};
    hold_equator(0, -approach * radius, environment.holds);
    SpringSystem<double> system(body, environment, {.threads = 1});
    move(system.levels(), 0, (before - approach) * radius, state);
    before = approach;
    const Status status = settle(system, state);
    Pressing pressing = by_springs(springs, state);
    pressing.status = status;
    add(approach, pressing);
    if (status != Status::ok) return;
  }
}

/// Each of the two equators is pushed by the approach, as if on a plane between them.
template <class Add>
void press_on_sphere(const PressRun& run, Add&& add) {
  constexpr double turn = 0.5;  // so that vertices do not meet vertices but at the poles
  const Vec3 below(0, 0, -2 * radius);
  const std::vector<BodyConfig> bodies{sphere_body(run.cells, Half::lower),
                                       sphere_body(run.cells, Half::upper, below)};
  std::optional<State<double>> state;
  double before = 0;
  for (const double approach : approaches) {
    if (approach > run.deepest) break;
    Environment environment{.contact = {.bodies = true, .friction = 0, .stiffness = run.stiffness}};
    hold_equator(0, -approach * radius, environment.holds);
    hold_equator(below[2], approach * radius, environment.holds);
    TouchingBodies pair(bodies, environment, "verlet", 1,
                        {cap(run.cells, Half::lower), cap(run.cells, Half::upper, below, turn)});
    if (state) pair.state() = *state;
    for (const std::size_t i : {0U, 1U})
      move(pair.levels(), i, (i == 0 ? before - approach : approach - before) * radius, pair.state());
    before = approach;
    Pressing pressing{.status = settle(pair.system(), pair.state())};
    for (const ContactForces::Point& point : pair.system().touches_at(pair.state())) {
      const double pressure = point.force.norm();
      pressing.force += pressure;
      pressing.moment += pressure * (point.at[0] * point.at[0] + point.at[1] * point.at[1]);
    }
    state = pair.state();
    add(approach, pressing);
    if (pressing.status != Status::ok) return;
  }
}

/// [N]
double hertz_force(double approach) {
  const double stiffness = elastic.young / (1 - elastic.poisson * elastic.poisson);
  return 4.0 / 3 * stiffness * radius * radius * std::pow(approach, 1.5);
}

/// What is allowed from a contact radius of so many cells on.
struct SphereBounds {
  double from, force, contact_radius;
};
constexpr SphereBounds sphere_bounds[]{{4, 0.03, 0.07}, {3, 0.05, 0.07}, {2, 0.12, 0.15}};

const char* judge(double radius_in_cells, double force_error, double radius_error) {
  constexpr double rounding = 1e-9;
  for (const SphereBounds& bounds : sphere_bounds)
    if (radius_in_cells > bounds.from - rounding)
      return std::abs(force_error) <= bounds.force && std::abs(radius_error) <= bounds.contact_radius ? "ok"
                                                                                                      : "off";
  return "not_claimed";
}

}  // namespace

const char* to_string(PressedOn on) {
  switch (on) {
    case PressedOn::impulse:
      return "plane, impulse";
    case PressedOn::penalty:
      return "plane, penalty";
    case PressedOn::sphere:
      return "sphere";
  }
  return "";
}

std::string PressRun::name() const {
  return fmt::format("sphere of {} cells on a {}, stiffness {:g}, to {:g} of the radius", cells,
                     to_string(on), stiffness, deepest);
}

double finite_over_hertz(double approach) {
  constexpr std::array<std::array<double, 2>, 7> figures{{{0.0005, 1.010},
                                                          {0.005, 1.038},
                                                          {0.01, 1.057},
                                                          {0.02, 1.084},
                                                          {0.03, 1.107},
                                                          {0.04, 1.126},
                                                          {0.06, 1.159}}};
  const auto* above = std::find_if(figures.begin() + 1, figures.end() - 1,
                                   [&](const auto& figure) { return approach <= figure[0]; });
  const auto& [low, of_low] = *(above - 1);
  const auto& [high, of_high] = *above;
  return of_low + (of_high - of_low) * std::log(approach / low) / std::log(high / low);
}

Table empty_spheres() {
  return Table({{"on"},
                {"stiffness"},
                {"cells"},
                {"approach_over_radius"},
                {"a_over_cell"},
                {"force", "N"},
                {"force_over_hertz"},
                {"finite_over_hertz"},
                {"force_error"},
                {"contact_radius_over_a"},
                {"status"}});
}

void add_press_run(const PressRun& run, Table& rows) {
  const auto add = [&](double approach, const Pressing& pressing) {
    const bool ok = pressing.status == Status::ok;
    const double a = std::sqrt(approach) * radius, hertz = hertz_force(approach),
                 finite = finite_over_hertz(approach), error = pressing.force / hertz / finite - 1,
                 contact_radius = std::sqrt(std::max(0.0, 2.5 * pressing.moment / pressing.force)) / a;
    const auto found = [&](double value) { return ok ? value : no_value; };
    rows.add({std::string(to_string(run.on)), run.stiffness, std::int64_t(run.cells), approach,
              a / cell_of(run.cells), found(pressing.force), found(pressing.force / hertz), finite,
              found(error), found(contact_radius),
              std::string(ok ? judge(a / cell_of(run.cells), error, contact_radius - 1)
                             : to_string(pressing.status))});
  };
  if (run.on == PressedOn::sphere)
    press_on_sphere(run, add);
  else
    press_on_plane(run, add);
}

namespace {

/// Durations of the finite sphere, linear elastic, by speed over c [R / c].
struct KnownImpact {
  double speed, duration;
};
constexpr KnownImpact known_impacts[]{
    {0.0016, 17.15}, {0.0028, 15.19}, {0.005, 13.35}, {0.009, 11.68}, {0.016, 10.19}};

/// By Hertz's theory [R / c]: 2 integral of dx / sqrt(1 - x^(5/2)) = 2.943 times the deepest approach over
/// the speed.
double hertz_duration(double speed) {
  const double approach =
      std::pow(5 * std::numbers::pi / 4 * (1 - elastic.poisson * elastic.poisson) * speed * speed, 0.4);
  return 2 * std::sqrt(std::numbers::pi) * std::tgamma(1.4) / std::tgamma(0.9) * approach / speed;
}

/// What is measured of a thrown sphere.
struct Impact {
  Status status = Status::ok;
  double left = 0;         ///< when the plane last pushed it; it begins on the plane [s]
  double restitution = 0;  ///< of its centre of mass
  bool still_pushed = false;
};

Vec3 velocity_of(const Body& body, const State<double>& state) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : body.sites())
    sum += body.mass(site) / body.total_mass() * state.v.at(site);
  return sum;
}

Impact throw_at_plane(const ImpactRun& run, double longest) {
  constexpr double push = 1e-9;  // change of speed in a step that is not rounding, over the speed
  const bool is_penalty = run.law == ContactLaw::penalty;
  const Body body(sphere_body(run.cells, Half::both));
  SpringSystem<double> system(body,
                              {.planes = {{.point = {0, 0, -radius},
                                           .contact = run.law,
                                           .restitution = is_penalty ? 1.0 : 0.0,
                                           .friction = 0}},
                               .contact_surface = cap(run.cells, Half::lower)},
                              {.threads = 1});
  const IntegratorInfo& info = find_integrator("verlet");
  const double dt = safe_share * stable_step(info, system.spectral_bound()),
               speed = run.speed * c_of_sphere();
  const auto method = info.make<double>({.dt = dt});
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : body.sites()) state.v.set(site, {0, 0, -speed});
  Impact impact;
  Work work;
  double before = -speed;
  while (state.t < longest) {
    impact.status = method->advance(system, state, state.t + dt, work);
    if (impact.status != Status::ok) return impact;
    const double now = velocity_of(body, state)[2];
    impact.still_pushed = std::abs(now - before) > push * speed;
    if (impact.still_pushed) impact.left = state.t;
    before = now;
  }
  impact.restitution = before / speed;
  return impact;
}

}  // namespace

std::string ImpactRun::name() const {
  return fmt::format("sphere of {} cells at {:g} c on a plane of law {}", cells, speed, to_string(law));
}

Table empty_impacts() {
  return Table({{"law"},
                {"cells"},
                {"speed_over_c"},
                {"duration", "R / c"},
                {"known_duration", "R / c"},
                {"hertz_duration", "R / c"},
                {"duration_error"},
                {"restitution"},
                {"status"}});
}

void add_impact_run(const ImpactRun& run, Table& rows) {
  constexpr int claimed_cells = 40;
  constexpr double most_error = 0.05, least_restitution = 0.995, longer = 1.3;
  const auto* known = std::find_if(std::begin(known_impacts), std::end(known_impacts),
                                   [&](const KnownImpact& one) { return one.speed == run.speed; });
  if (known == std::end(known_impacts)) throw std::logic_error("no known duration of " + run.name());
  const double time = radius / c_of_sphere();
  const Impact impact = throw_at_plane(run, longer * known->duration * time);
  const auto add = [&](double duration, double restitution, std::string status) {
    rows.add({std::string(to_string(run.law)), std::int64_t(run.cells), run.speed, duration, known->duration,
              hertz_duration(run.speed), duration / known->duration - 1, restitution, std::move(status)});
  };
  if (impact.status != Status::ok) return add(no_value, no_value, std::string(to_string(impact.status)));
  if (impact.still_pushed) return add(no_value, no_value, "never_left");
  const double duration = impact.left / time;
  const bool ok =
      std::abs(duration / known->duration - 1) <= most_error && impact.restitution >= least_restitution;
  add(duration, impact.restitution, run.cells != claimed_cells ? "not_claimed" : ok ? "ok" : "off");
}

SphereConfig sphere_config(bool quick) {
  SphereConfig config;
  const std::vector<int> all = quick ? std::vector{10, 20} : std::vector{10, 20, 40};
  for (const PressedOn on : {PressedOn::impulse, PressedOn::penalty})
    for (const int cells : all) config.pressed.push_back({on, cells});
  if (!quick) config.pressed.push_back({.on = PressedOn::impulse, .cells = 80, .deepest = 0.02});
  for (const double stiffness : {1.0, 8.0})
    for (const int cells : quick ? std::vector{10} : all)
      config.pressed.push_back({PressedOn::sphere, cells, stiffness});
  for (const ContactLaw law : {ContactLaw::impulse, ContactLaw::penalty})
    for (const int cells : quick ? std::vector{20} : std::vector{20, 40})
      for (const KnownImpact& known : known_impacts) config.impacts.push_back({law, cells, known.speed});
  return config;
}

}  // namespace mss::studies::contact
