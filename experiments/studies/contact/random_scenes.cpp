// Bodies that meet as chance has it: whatever is not as it should be shows as such.
#include "experiments/studies/contact/random_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/error.hpp"
#include "core/scene/scene.hpp"
#include "experiments/harness/progress.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/contact/scene_text.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::contact {

namespace {

constexpr double frame = 1.0 / 60;  ///< step of methods without a limit [s]

/// Random numbers that are the same with every standard library, and with every compiler where no expression
/// draws twice.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) { random_.discard(8); }
  double between(double low, double high) { return low + (high - low) * double(random_() >> 11) * 0x1p-53; }
  /// Its logarithm is evenly distributed.
  double scale(double low, double high) { return low * std::pow(high / low, between(0, 1)); }
  int whole(int low, int high) { return low + int(between(0, 1) * (high - low + 1)); }
  bool chance(double share) { return between(0, 1) < share; }
  Vec3 direction() {
    for (;;) {
      Vec3 v;
      for (const int axis : {2, 1, 0}) v[axis] = between(-1, 1);
      if (const double length = v.norm(); length > 0.1 && length <= 1) return v / length;
    }
  }

 private:
  std::mt19937_64 random_;
};

/// A number as scene files have it, short: what it was before does not matter.
double rounded(double x) { return std::stod(fmt::format("{:.4g}", x)); }
Vec3 rounded(const Vec3& x) { return {rounded(x[0]), rounded(x[1]), rounded(x[2])}; }

struct RandomBody {
  std::array<int, 3> cells{};
  double cell_size = 0, young = 0, density = 0, poisson = 0;
  Vec3 origin = Vec3::Zero(), velocity = Vec3::Zero(), turn = Vec3::Zero();

  Vec3 extent() const { return cell_size * Vec3(cells[0], cells[1], cells[2]); }
  Vec3 middle() const { return origin + extent() / 2; }
  double wave_speed() const { return std::sqrt(young / density); }
  bool overlaps(const RandomBody& other) const {
    const double gap = 0.1 * std::max(cell_size, other.cell_size);
    return ((origin - other.origin - other.extent()).array() < gap).all() &&
           ((other.origin - origin - extent()).array() < gap).all();
  }
};

RandomBody random_body(Dice& dice) {
  RandomBody body;
  for (int& n : body.cells) n = dice.whole(1, 4);
  body.cell_size = rounded(dice.scale(0.02, 0.08));
  body.young = rounded(dice.scale(3e4, 1e7));
  body.density = rounded(dice.scale(300, 2000));
  body.poisson = rounded(dice.between(0.1, 0.4));
  return body;
}

/// Farther and farther from the origin until it overlaps none of the others; a few do overlap.
void place(RandomBody& body, const std::vector<RandomBody>& others, bool anywhere, Dice& dice) {
  for (double radius = 0;; radius += 0.02) {
    body.origin = rounded(Vec3(radius * dice.direction() - body.extent() / 2));
    if (anywhere || std::none_of(others.begin(), others.end(),
                                 [&](const RandomBody& other) { return body.overlaps(other); }))
      return;
  }
}

/// Towards the origin, up to a share of the waves' speed, and turning.
void set_moving(RandomBody& body, Dice& dice) {
  const double speed = std::min(5.0, dice.scale(0.01, 0.2) * body.wave_speed());
  const Vec3 aim = (0.03 * dice.direction() - body.middle()).stableNormalized();
  body.velocity = rounded(Vec3(speed * aim));
  if (!dice.chance(0.5)) return;
  const Vec3 axis = dice.direction();
  body.turn = rounded(Vec3(dice.scale(0.5, 20) * axis));
}

std::vector<RandomBody> random_bodies(Dice& dice) {
  std::vector<RandomBody> bodies;
  const int count = dice.whole(2, 5);
  const bool anywhere = dice.chance(0.1);
  for (int i = 0; i < count; ++i) {
    RandomBody body = random_body(dice);
    place(body, bodies, anywhere, dice);
    set_moving(body, dice);
    bodies.push_back(body);
  }
  return bodies;
}

std::string damping_of(Dice& dice) {
  if (dice.chance(0.5)) return "";
  if (dice.chance(0.5)) return fmt::format("[damping]\nratio = {}\n\n", rounded(dice.scale(0.01, 0.3)));
  return fmt::format("[damping]\nviscosity = {}\n\n", rounded(dice.scale(0.1, 20)));
}

std::string contact_of(Dice& dice) {
  std::string said = fmt::format("[contact]\nbodies = true\nself = {}\n", dice.chance(0.3));
  said += fmt::format("friction = {}\n", dice.chance(0.4) ? 0.0 : rounded(dice.between(0, 1)));
  if (dice.chance(0.5)) said += fmt::format("stiffness = {}\n", rounded(dice.scale(0.1, 10)));
  return said + "\n";
}

/// Below, or beside, all of the bodies.
std::string planes_of(const std::vector<RandomBody>& bodies, Dice& dice) {
  std::string said;
  const char* law = dice.chance(0.7) ? "impulse" : "penalty";
  const int count = dice.whole(1, 3);
  for (int i = 0; i < count; ++i) {
    const Vec3 normal = i == 0 ? Vec3(Vec3::UnitZ()) : rounded(dice.direction());
    double lowest = 0;
    for (const RandomBody& body : bodies)
      lowest = std::min(lowest, normal.normalized().dot(body.middle()) - body.extent().norm() / 2);
    const Vec3 point = rounded(Vec3(lowest * 1.001 * normal.normalized()));
    const double restitution = rounded(dice.between(0, 1)), friction = rounded(dice.between(0, 1));
    said += fmt::format(
        "[[plane]]\npoint = {}\nnormal = {}\ncontact = \"{}\"\nfriction = {}\nrestitution = {}\n\n",
        scene_text(point), scene_text(normal), law, friction, restitution);
  }
  return said;
}

const IntegratorInfo& random_method(Dice& dice) {
  std::vector<const IntegratorInfo*> moving;
  for (const IntegratorInfo& info : integrators())
    if (info.moves_particles() && info.variant_of.empty()) moving.push_back(&info);
  if (dice.chance(0.3)) return find_integrator(dice.chance(0.5) ? "verlet" : "backward_euler");
  return *moving[std::size_t(dice.whole(0, int(moving.size()) - 1))];
}

/// Until they have met and parted, or for some tenths of a second.
double duration_of(const std::vector<RandomBody>& bodies) {
  double far = 0, fastest = 0;
  for (const RandomBody& body : bodies) {
    far = std::max(far, body.middle().norm() + body.extent().norm());
    fastest = std::max(fastest, body.velocity.norm());
  }
  return rounded(std::clamp(2 * far / fastest, 0.05, 0.3));
}

std::string text_of(const RandomBody& body) {
  std::string said =
      fmt::format("[[body]]\ncells = [{}, {}, {}]\ncell_size = {}\norigin = {}\n", body.cells[0],
                  body.cells[1], body.cells[2], body.cell_size, scene_text(body.origin));
  said += fmt::format("material = {{ young = {}, poisson = {}, density = {} }}\n", body.young, body.poisson,
                      body.density);
  return said + fmt::format("start = {{ velocity = {}, angular_velocity = {} }}\n\n",
                            scene_text(body.velocity), scene_text(body.turn));
}

}  // namespace

std::string random_scene(std::uint64_t seed) {
  Dice dice(seed);
  const std::vector<RandomBody> bodies = random_bodies(dice);
  std::string said = fmt::format("# Scene {} of `mss validate contact`.\n", seed);
  for (const RandomBody& body : bodies) said += text_of(body);
  const std::string contact = contact_of(dice);
  said += damping_of(dice) + contact;
  const bool falls = dice.chance(0.4), stops = falls || dice.chance(0.2);
  if (falls) said += "[environment]\ngravity = [0, 0, -9.81]\n\n";
  if (stops) said += planes_of(bodies, dice);
  const IntegratorInfo& method = random_method(dice);
  const double duration = duration_of(bodies);
  said += fmt::format("[solve]\nintegrator = \"{}\"\n", method.name);
  if (method.limit)
    said += "dt = \"safe\"\n";
  else if (method.stepping == Stepping::fixed)
    said += fmt::format("dt = {}\n", rounded(dice.chance(0.5) ? frame : dice.scale(1e-3, frame)));
  return said + fmt::format("duration = {}\nevery = {}\nthreads = 1\n", duration, rounded(duration / 20));
}

namespace {

constexpr double kept = 1e-9;            ///< of momentum
constexpr double energy_allowed = 0.01;  ///< of explicit methods, at half their safe steps
constexpr double energy_allowed_of_frames = 0.05;
constexpr double deepest_followed = 0.48;  ///< cells; from half a cell on contact loses a vertex

/// What is compared of a run.
struct Balance {
  std::size_t touches = 0;
  double depth = 0;     ///< deepest, over the smallest cell's size
  double momentum = 0;  ///< change that gravity does not explain, over what moves; 0 where planes take it
  double spin = 0;      ///< the same of angular momentum about the common centre of mass
  double energy = 0;    ///< largest gain over what is at play
};

double mass_of(const Scene& scene) {
  double mass = 0;
  for (const SceneBody* one : bodies_of(scene)) mass += Body(one->body).total_mass();
  return mass;
}

Balance balance_of(const Scene& scene, const SimulationResult& result) {
  const double mass = mass_of(scene);
  const SeriesRow& start = result.series.front();
  Balance balance;
  double at_play = 0, gained = 0, moving = 0, off = 0, turned = 0, turning = 0;
  for (const SeriesRow& row : result.series) {
    const Vec3 expected = start.momentum + mass * row.t * scene.environment.gravity;
    off = std::max(off, (row.momentum - expected).norm());
    moving = std::max(moving, std::sqrt(2 * mass * row.kinetic));
    turned = std::max(turned, (row.angular_momentum - start.angular_momentum).norm());
    turning = std::max(turning, row.angular_momentum.norm());
    at_play = std::max(at_play,
                       row.mechanical() + std::max(0.0, start.external_potential - row.external_potential));
    gained = std::max(gained, row.total() - start.total());
    if (row.bodies.contact) balance.touches = std::max(balance.touches, row.bodies.contact->touches);
  }
  double size = 0;
  for (const SceneBody* one : bodies_of(scene)) size = std::max(size, one->body.origin.norm());
  balance.depth = result.contact ? result.contact->depth_so_far : 0;
  if (scene.environment.planes.empty()) {
    balance.momentum = off / moving;
    balance.spin = turned / std::max(turning, size * moving);
  }
  balance.energy = gained / at_play;
  return balance;
}

/// Methods that change positions and velocities by forces at positions alone, one after the other.
bool keeps_spin(const IntegratorInfo& method) { return method.symplectic && !method.implicit; }

std::string judge(const Scene& scene, const Balance& balance) {
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  if (!(balance.momentum < kept)) return "gains_momentum";
  if (keeps_spin(method) && !(balance.spin < kept)) return "turns";
  if (!(balance.depth < deepest_followed)) return "sinks_in";
  return balance.energy < (method.limit ? energy_allowed : energy_allowed_of_frames) ? "ok" : "gains_energy";
}

/// Half the safe step, at which explicit methods keep energy, and not too many of them.
void halve_step(Scene& scene) {
  constexpr double most_steps = 3000;
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  if (!method.limit) return;
  const Scene& known = scene;
  const Body body(known.body);
  const OtherBodies others = other_bodies(known);
  const auto system = make_solid<double>(known, body, nullptr, others);
  SolveConfig& solve = scene.solve;
  solve.dt = safe_share / 2 * stable_step(method, system->spectral_bound());
  solve.duration = std::min(solve.duration, most_steps * *solve.dt);
  solve.every = std::min(solve.every, solve.duration / 20);
}

void add(std::uint64_t seed, const Scene& scene, double dt, const Balance& b, const std::string& status,
         const std::string& reason, Table& rows) {
  const Environment& environment = scene.environment;
  std::size_t cells = 0;
  for (const SceneBody* one : bodies_of(scene)) cells += Body(one->body).cell_count();
  rows.add({std::int64_t(seed), std::int64_t(bodies_of(scene).size()), std::int64_t(cells),
            scene.solve.integrator, dt, environment.contact.self ? std::string("yes") : std::string("no"),
            environment.contact.friction, environment.contact.stiffness,
            environment.planes.empty() ? std::string("none") : to_string(environment.planes[0].contact),
            std::int64_t(b.touches), b.depth, b.momentum, b.spin, b.energy, status, reason});
}

}  // namespace

Table empty_random() {
  return Table({{"seed"},
                {"bodies"},
                {"cells"},
                {"integrator"},
                {"dt", "s"},
                {"self"},
                {"friction"},
                {"stiffness"},
                {"planes"},
                {"touches"},
                {"depth"},
                {"momentum"},
                {"angular_momentum"},
                {"energy"},
                {"status"},
                {"reason"}});
}

void add_random_scene(std::uint64_t seed, Table& rows) {
  Scene scene = parse_scene(random_scene(seed));
  constexpr Balance none{.momentum = no_value, .spin = no_value, .energy = no_value};
  try {
    check_solve(scene);
    halve_step(scene);
    Progress silent;
    const SimulationResult result = simulate(scene, silent);
    const Balance balance = balance_of(scene, result);
    add(seed, scene, std::isfinite(result.dt) ? result.dt : 0, balance,
        result.status == Status::ok ? judge(scene, balance) : std::string(to_string(result.status)), "",
        rows);
  } catch (const InputError& error) {
    add(seed, scene, no_value, none, "refused", error.what(), rows);
  }
}

std::string random_summary(const Table& rows) {
  std::string lines;
  for (const std::string& method : rows.distinct("integrator")) {
    const Table of_method = rows.where("integrator", method);
    lines += fmt::format("{:<21} of {:3} random scenes", method, of_method.size());
    for (const std::string& status : of_method.distinct("status"))
      lines += fmt::format(", {} {}", of_method.where("status", status).size(), status);
    lines += "\n";
  }
  return lines;
}

}  // namespace mss::studies::contact
