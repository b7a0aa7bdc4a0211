#include "experiments/simulation/bench_scenes.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/scene.hpp"
#include "experiments/simulation/equilibrium.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/scene_files.hpp"

namespace mss {

namespace {

constexpr double density = 1000, poisson = 0.3, face_share = 0.5;
constexpr double gravity = 9.81;                            // [m/s^2]
constexpr double fall_speed = 1.5;                          // at the start, what 11 cm of fall make [m/s]
constexpr double start_height = 0.01;                       // of what falls [m]
constexpr double slope_degrees = 19, slope_friction = 0.5;  // it slides from 26.6 degrees on
constexpr double spin_rate = 10;                            // [rad/s]

/// Frame-sized steps cannot resolve how single particles rebound: none do, with any method.
Plane ground(double friction) { return {.restitution = 0, .friction = friction}; }

/// A cube with an edge of `size` [m].
BodyConfig cube_of(double size, int cells) {
  return {.voxels = VoxelGrid::box(cells, cells, cells), .cell_size = size / cells};
}

BenchSetup held_box(int cells) {
  return {.body = cube_of(1, cells),
          .environment = {.gravity = {0, 0, -gravity}, .holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}}}};
}

/// Two blocks upright, and a third beside the upper one.
BenchSetup bracket(int cells) {
  constexpr double thickness = 0.1;
  BodyConfig body{.voxels = VoxelGrid::box(2 * cells, cells, 2 * cells), .cell_size = thickness / cells};
  for (int i = cells; i < 2 * cells; ++i)
    for (int j = 0; j < cells; ++j)
      for (int k = 0; k < cells; ++k) body.voxels.set(i, j, k, false);
  return {.body = body,
          .environment = {.gravity = {0, 0, -gravity},
                          .holds = {{.box = {{0, 0, 0}, {thickness, thickness, 0}}}}}};
}

/// Lowest rest position of the particles [m].
double lowest(const BodyConfig& config) {
  const Body body(config);
  double least = std::numeric_limits<double>::infinity();
  for (const std::ptrdiff_t site : body.sites()) least = std::min(least, body.rest_position(site)[2]);
  return least;
}

BenchSetup falling(BodyConfig body) {
  body.origin[2] += start_height - lowest(body);
  return {.body = std::move(body),
          .environment = {.gravity = {0, 0, -gravity}, .planes = {ground(0.3)}},
          .velocity = {0, 0, -fall_speed}};
}

BenchSetup ball(int cells) {
  constexpr double diameter = 0.4;
  constexpr int divisions = 16;
  MeshFill fill = fill_mesh(icosphere(diameter / 2, divisions), {.cell_size = diameter / cells});
  return falling({.voxels = std::move(fill.voxels),
                  .contents = std::move(fill.contents),
                  .content_of = std::move(fill.content_of),
                  .cell_size = fill.cell_size,
                  .origin = fill.origin});
}

BenchSetup bear(int cells) {
  const Scene scene = load_scene(scene_file("mesh_bear"), {fmt::format("body.cells_across={}", cells)});
  return falling({.voxels = scene.body.voxels,
                  .contents = scene.body.contents,
                  .content_of = scene.body.content_of,
                  .cell_size = scene.body.cell_size,
                  .origin = scene.body.origin});
}

BenchSetup spinning_cube(int cells) {
  return {.body = cube_of(0.5, cells), .angular_velocity = spin_rate * Vec3(0.36, 0.48, 0.8)};
}

/// A cube that lies on the plane z = 0, at rest under gravity, which is inclined by so many degrees, until
/// something as heavy is put on its top, whose weight presses along z: so the foot is never free to slip.
BenchSetup loaded_block(int cells, double degrees) {
  constexpr double size = 0.4;
  const double angle = degrees * std::numbers::pi / 180;
  const Vec3 down = Vec3(std::sin(angle), 0, -std::cos(angle));
  const double weight = gravity * density * size * size * size;
  return {.body = cube_of(size, cells),
          .environment = {.gravity = gravity * down,
                          .loads = {{.box = {{0, 0, size}, {size, size, size}}, .force = {0, 0, -weight}}},
                          .planes = {ground(slope_friction)}}};
}
BenchSetup block(int cells) { return loaded_block(cells, 0); }
BenchSetup block_on_slope(int cells) { return loaded_block(cells, slope_degrees); }

/// Means over particles, weighted by mass, of positions.
Vec3 centre_of(const Body& body, const Field<double>& x) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : body.sites()) sum += body.mass(site) * x.at(site);
  return sum / body.total_mass();
}

/// Depth of the deepest particle behind a plane at any frame [m].
double depth_of(const BenchBody& b, const FramePositions& motion) {
  double depth = 0;
  for (const Field<double>& x : motion)
    for (const Plane& plane : b.setup.environment.planes)
      for (const std::ptrdiff_t site : b.body.sites()) depth = std::max(depth, -plane.gap(x.at(site)));
  return depth;
}

bool stands(const BenchScene& scene) {
  return scene.task == BenchTask::rest || scene.task == BenchTask::stick;
}

/// Where a block is at rest before it is loaded, its foot held where it is. Throws std::runtime_error if that
/// is not found.
Field<double> standing(const BenchSetup& setup, int threads) {
  constexpr double wide = 1e3;
  const MovingBody held(
      setup.body,
      {.gravity = setup.environment.gravity, .holds = {{.box = {{-wide, -wide, 0}, {wide, wide, 0}}}}},
      threads);
  Equilibrium at_rest = find_equilibrium(held.system, [](const Vec3& rest) { return rest; });
  if (at_rest.status != Status::ok) throw std::runtime_error("a block finds no rest on its foot");
  return std::move(at_rest.state.x);
}

/// Mean way of the particles that begin on the ground [m].
Vec3 way_of_foot(const BenchBody& b, const Field<double>& x) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const std::ptrdiff_t site : b.body.sites())
    if (b.start.x.at(site)[2] < 1e-9) sum += x.at(site) - b.start.x.at(site), ++count;
  return sum / count;
}

double duration_of(const FramePositions& motion) { return double(motion.size()) * frame; }

std::string complaint_of_sag(const BenchBody& b, const FramePositions& motion) {
  const Vec3 way = centre_of(b.body, motion.back()) - centre_of(b.body, b.start.x);
  return way.dot(b.setup.environment.gravity) > 0 ? "" : "the body has not sagged";
}

std::string complaint_of_landing(const BenchBody& b, const FramePositions& motion) {
  const double t = duration_of(motion),
               unhindered = centre_of(b.body, b.start.x)[2] - fall_speed * t - gravity / 2 * t * t;
  return centre_of(b.body, motion.back())[2] > unhindered + b.body.config().cell_size
             ? ""
             : "the body has not touched the ground";
}

/// Its angle about the axis, from frame to frame.
std::string complaint_of_spin(const BenchBody& b, const FramePositions& motion) {
  const Vec3 axis = b.setup.angular_velocity.normalized();
  double angle = 0;
  const Field<double>* before = &b.start.x;
  for (const Field<double>& x : motion) {
    double sine = 0, cosine = 0;
    const Vec3 here = centre_of(b.body, x), there = centre_of(b.body, *before);
    for (const std::ptrdiff_t site : b.body.sites()) {
      const Vec3 now = x.at(site) - here, then = before->at(site) - there;
      sine += axis.dot(then.cross(now));
      cosine += now.dot(then) - axis.dot(now) * axis.dot(then);
    }
    angle += std::atan2(sine, cosine);
    before = &x;
  }
  const double expected = spin_rate * duration_of(motion);
  return std::abs(angle / expected - 1) < 0.1
             ? ""
             : fmt::format("the body has turned by {:.2g} rad, not by {:.2g}", angle, expected);
}

std::string complaint_of_block(const BenchBody& b, const FramePositions& motion) {
  const double t = duration_of(motion),
               free_way = std::sin(slope_degrees * std::numbers::pi / 180) * gravity / 2 * t * t;
  const Vec3 way = way_of_foot(b, motion.back());
  if (std::hypot(way[0], way[1]) > free_way / 20) return "the block has not stayed where it was";
  if (way[2] > 0.01 * b.body.config().cell_size * b.body.config().voxels.nz())
    return "the block has left the ground";
  return complaint_of_sag(b, motion);
}

}  // namespace

const std::vector<BenchScene>& bench_scenes() {
  static const std::vector<BenchScene> all{
      {.name = "held_box",
       .label = "held box",
       .description = "a cube of 1 m held at one face, released straight under gravity; cells an edge",
       .task = BenchTask::sag,
       .cells = 10,
       .quick_cells = 6,
       .frames = 10,
       .set_up = held_box},
      {.name = "bracket",
       .label = "L bracket",
       .description =
           "an L of 0.2 m, 0.1 m thick, held at its foot, released under gravity; cells a thickness",
       .task = BenchTask::sag,
       .cells = 5,
       .quick_cells = 4,
       .frames = 10,
       .set_up = bracket},
      {.name = "ball",
       .label = "dropped ball",
       .description = "a ball of 0.4 m that comes to the ground at 1.5 m/s; cells a diameter",
       .task = BenchTask::land,
       .cells = 12,
       .quick_cells = 8,
       .frames = 12,
       .truth = "semi_implicit_euler",
       .truth_share = 0.0625,
       .set_up = ball},
      {.name = "bear",
       .label = "landing bear",
       .description = "the mesh of a bear, 0.3 m, that comes to the ground at 1.5 m/s; cells its height",
       .task = BenchTask::land,
       .cells = 10,
       .quick_cells = 8,
       .frames = 12,
       .truth = "semi_implicit_euler",
       .truth_share = 0.0625,
       .set_up = bear},
      {.name = "spin",
       .label = "spinning body",
       .description = "a free cube of 0.5 m that turns at 10 rad/s; cells an edge",
       .task = BenchTask::spin,
       .cells = 8,
       .quick_cells = 5,
       .frames = 20,
       .set_up = spinning_cube},
      {.name = "block",
       .label = "loaded block",
       .description = "a cube of 0.4 m at rest on the ground, on which as much weight is put; cells an edge",
       .task = BenchTask::rest,
       .cells = 8,
       .quick_cells = 5,
       .frames = 12,
       .truth = "velocity_verlet",
       .truth_share = 0.03125,
       .set_up = block},
      {.name = "slope",
       .label = "block on a slope",
       .description =
           "a cube of 0.4 m on a slope of 19 degrees, friction 0.5, on which it stays when as much weight is "
           "put on it; cells an edge",
       .task = BenchTask::stick,
       .cells = 8,
       .quick_cells = 5,
       .frames = 12,
       .truth = "velocity_verlet",
       .truth_share = 0.03125,
       .set_up = block_on_slope}};
  return all;
}

const BenchScene& find_bench_scene(const std::string& name) {
  for (const BenchScene& scene : bench_scenes())
    if (scene.name == name) return scene;
  throw std::logic_error("no bench scene " + name);
}

std::string BenchCase::name() const {
  constexpr std::array words{"soft", "medium", "stiff"};
  std::string all = scene;
  for (std::size_t i = 0; i < bench_moduli.size(); ++i)
    if (young == bench_moduli[i]) all += fmt::format("_{}", words[i]);
  return ratio == bench_ratios.back() ? all + "_damped" : all;
}

std::string BenchCase::description(int cells) const {
  return fmt::format("{}: {}; E = {:g} kPa, damping ratio {}", find_bench_scene(scene).description, cells,
                     young / 1e3, ratio);
}

const std::vector<BenchCase>& bench_cases() {
  static const std::vector<BenchCase> all = [] {
    std::vector<BenchCase> cases;
    for (const BenchScene& scene : bench_scenes())
      for (const double young : bench_moduli)
        for (const double ratio : bench_ratios) cases.push_back({scene.name, young, ratio});
    return cases;
  }();
  return all;
}

std::vector<std::string> bench_case_names() {
  std::vector<std::string> names;
  for (const BenchCase& c : bench_cases()) names.push_back(c.name());
  return names;
}

const BenchCase& find_bench_case(const std::string& name) {
  for (const BenchCase& c : bench_cases())
    if (c.name() == name) return c;
  throw std::logic_error("no bench case " + name);
}

Damping damping_of_ratio(double ratio) { return {.law = Damping::Law::ratio, .zeta = ratio}; }

// Of an edge spring k = (2 - t) mu h between masses rho h^3: 2 zeta sqrt(k m / 2) = k eta / mu.
Damping viscosity_like_ratio(double ratio, double young, double cell_size) {
  const double shear = young / (2 * (1 + poisson));
  return {.law = Damping::Law::viscosity,
          .viscosity = 2 * ratio * cell_size * std::sqrt(density * shear / (2 * (2 - face_share)))};
}

BenchSetup bench_setup(const BenchScene& scene, int cells, const BenchMaterial& material) {
  BenchSetup setup = scene.set_up(cells);
  setup.body.density = density;
  setup.body.damping = material.damping;
  setup.body.fill({.young = material.young, .poisson = poisson}, face_share);
  return setup;
}

BenchBody::BenchBody(const BenchScene& of, int cells, const BenchMaterial& material, int threads)
    : BenchBody(of, bench_setup(of, cells, material), threads) {}

BenchBody::BenchBody(const BenchScene& of, BenchSetup with, int threads)
    : MovingBody(with.body, with.environment, threads), scene(of), setup(std::move(with)) {
  if (stands(scene)) start.x = standing(setup, threads);
  const Vec3 centre = centre_of(body, start.x);
  for (const std::ptrdiff_t site : body.sites())
    start.v.set(site, setup.velocity + setup.angular_velocity.cross(start.x.at(site) - centre));
  system.constrain(0, start.x, start.v);
}

std::string bench_complaint(const BenchBody& body, const FramePositions& motion) {
  if (motion.empty()) return "there is no motion";
  if (depth_of(body, motion) > 1e-6 * body.body.config().cell_size) return "the body is behind a plane";
  switch (body.scene.task) {
    case BenchTask::sag:
      return complaint_of_sag(body, motion);
    case BenchTask::land:
      return complaint_of_landing(body, motion);
    case BenchTask::spin:
      return complaint_of_spin(body, motion);
    case BenchTask::rest:
    case BenchTask::stick:
      return complaint_of_block(body, motion);
  }
  return {};
}

namespace {

ExplicitSteps truth_steps(const BenchBody& body, double share) {
  return explicit_steps(find_integrator(body.scene.truth), body.system.spectral_bound(), frame, share);
}

TrueMotion failed(const char* complaint) {
  TrueMotion none;
  none.complaint = complaint;
  return none;
}

/// How long both runs will take [s].
double seconds_of_truth(const BenchBody& body) {
  const ExplicitSteps fine = truth_steps(body, body.scene.truth_share);
  const double forces = fine.info->order_undamped > 2 ? 4 : 1;
  return 1.5 * forces * explicit_step_seconds(body.system) * double(fine.steps) * body.scene.frames;
}

}  // namespace

TrueMotion find_true_motion(const BenchBody& body, double most_seconds, int threads) {
  if (std::isfinite(most_seconds) && seconds_of_truth(body) > most_seconds)
    return failed("the reference of the motion would take too long");
  const BenchBody mover = body.with_threads(threads);
  const auto motion_with = [&](double share, const FrameObserver& observer) {
    const ExplicitSteps choice = truth_steps(body, share);
    return measure_motion(mover, *choice.info, {.dt = choice.dt}, body.scene.frames,
                          std::numeric_limits<double>::infinity(), observer)
        .motion;
  };
  MotionWatch watch(body);
  TrueMotion truth;
  truth.positions =
      motion_with(body.scene.truth_share, [&](const State<double>& state) { watch.add(state); });
  const FramePositions coarser = motion_with(2 * body.scene.truth_share, {});
  if (truth.positions.empty() || coarser.empty()) return failed("the reference of the motion failed");
  truth.extremes = watch.extremes();
  truth.scale = squared_displacement(body, truth.positions);
  truth.uncertainty = truth.error_of(body, coarser);
  truth.complaint = bench_complaint(body, truth.positions);
  return truth;
}

}  // namespace mss
