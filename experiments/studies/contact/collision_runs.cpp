// Bodies that hit each other: bars, whose exact solution is a wave's, and blocks, which keep what they have.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "experiments/studies/contact/collision.hpp"
#include "experiments/studies/contact/touching.hpp"

namespace mss::studies::contact {

namespace {

constexpr double block_cell = 0.05;           // [m]
constexpr ElasticConstants rubber{1e6, 0.3};  // [Pa]
constexpr double density = 1000;              // [kg/m^3]

BodyConfig block_of(const VoxelGrid& voxels, const Vec3& origin) {
  BodyConfig config{.voxels = voxels, .cell_size = block_cell, .origin = origin, .density = density};
  config.fill(rubber, 0.5);
  return config;
}

/// Speed of waves where nothing moves sideways [m/s].
double bar_wave_speed() {
  const auto [young, nu] = rubber;
  return std::sqrt(young * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / density);
}

/// Two bars along x, the right one at rest, that touch.
class Bars {
 public:
  explicit Bars(const BarRun& run)
      : length_(run.cells * block_cell),
        bodies_({bar(run, -length_), bar(run, 0)},
                {.holds = {{.box = everywhere(), .axes = {false, true, true}}},
                 .contact = {.bodies = true, .friction = 0, .stiffness = run.stiffness}},
                "velocity_verlet", 1) {
    bodies_.push(0, {run.speed * bar_wave_speed(), 0, 0});
  }
  TouchingBodies& bodies() { return bodies_; }
  double length() const { return length_; }
  /// Between the ends that meet [m].
  double gap() const { return face(1) - face(0); }
  /// Between them [N]
  double force() const { return bodies_.system().contact_at(bodies_.state())->force; }
  double velocity(std::size_t bar) const { return bodies_.mean(bar, bodies_.state().v)[0]; }
  double mass() const { return bodies_.body(0).total_mass(); }
  double momentum() const { return mass() * (velocity(0) + velocity(1)); }
  /// Energy that is not of the bars' mean motion [J].
  double vibration() const {
    return bodies_.energy() - mass() / 2 * (velocity(0) * velocity(0) + velocity(1) * velocity(1));
  }

 private:
  static Box everywhere() {
    const double far = std::numeric_limits<double>::max();
    return {Vec3::Constant(-far), Vec3::Constant(far)};
  }
  static BodyConfig bar(const BarRun& run, double from) {
    return block_of(VoxelGrid::box(run.cells, run.across, run.across), {from, 0, 0});
  }
  /// Mean place of the end that rests at x = 0 [m].
  double face(std::size_t bar) const {
    const Level& level = bodies_.levels()[bar];
    double sum = 0;
    int count = 0;
    for (const std::ptrdiff_t site : level.body.sites())
      if (std::abs(level.body.rest_position(site)[0]) < 1e-9)
        sum += bodies_.state().x.at(level.first + site)[0], ++count;
    return sum / count;
  }

  double length_;
  TouchingBodies bodies_;
};

/// What is measured of a collision of bars.
struct BarCollision {
  Status status = Status::ok;
  std::optional<double> left;  ///< when they parted [s]
  double impulse = 0;          ///< of one on the other [N s]
  double moment = 0;           ///< the same times its time [N s^2]
  double momentum = 0;         ///< largest change of all [kg m/s]
  double depth = 0;            ///< largest [m]
};

/// To half as long again as the exact contact lasts.
BarCollision collide(Bars& bars) {
  constexpr double most = 1.5;
  BarCollision seen;
  const double begin = bars.momentum(), end = most * 2 * bars.length() / bar_wave_speed();
  TouchingBodies& bodies = bars.bodies();
  while (bodies.state().t < end) {
    const double before = bars.gap();
    seen.status = bodies.step();
    if (seen.status != Status::ok) break;
    const double gap = bars.gap();
    if (before < 0 && gap >= 0) seen.left = bodies.state().t - bodies.dt() * gap / (gap - before);
    if (before >= 0 && gap < 0) seen.left.reset();
    seen.impulse += bodies.dt() * bars.force();
    seen.moment += bodies.dt() * bars.force() * bodies.state().t;
    seen.momentum = std::max(seen.momentum, std::abs(bars.momentum() - begin));
    seen.depth = std::max(seen.depth, -gap);
  }
  return seen;
}

/// What is allowed of a bar of so many cells.
struct BarBounds {
  int cells;
  double duration, restitution, vibration;
};
constexpr BarBounds bar_bounds[]{{20, 0.04, 0.95, 0.04}, {40, 0.02, 0.97, 0.025}};
constexpr double claimed_speed = 0.01, most_momentum = 1e-12;

/// Of a collision of bars; durations over the exact one.
struct BarFigures {
  double touching = no_value, duration = no_value, restitution = no_value, vibration = no_value;
};

const char* judge(const BarRun& run, const BarFigures& figures, double momentum) {
  const auto* bounds = std::find_if(std::begin(bar_bounds), std::end(bar_bounds),
                                    [&](const BarBounds& one) { return one.cells == run.cells; });
  if (bounds == std::end(bar_bounds) || run.speed != claimed_speed) return "not_claimed";
  const bool ok = std::abs(figures.duration - 1) <= bounds->duration &&
                  figures.restitution >= bounds->restitution && figures.vibration <= bounds->vibration &&
                  momentum <= most_momentum;
  return ok ? "ok" : "off";
}

}  // namespace

std::string BarRun::name() const {
  return fmt::format("bars of {} x {} cells, stiffness {:g}, at {:g} c", cells, across, stiffness, speed);
}

Table empty_bars() {
  return Table({{"cells"},
                {"across"},
                {"stiffness"},
                {"speed_over_c"},
                {"dt", "s"},
                {"touching_over_exact"},
                {"duration_over_exact"},
                {"restitution"},
                {"vibration"},
                {"momentum_change"},
                {"depth_over_cell"},
                {"status"}});
}

void add_bar_run(const BarRun& run, Table& rows) {
  Bars bars(run);
  const double energy = bars.bodies().energy(), speed = bars.velocity(0), momentum = bars.momentum(),
               exact = 2 * bars.length() / bar_wave_speed();
  const BarCollision seen = collide(bars);
  const auto add = [&](const BarFigures& figures, std::string status) {
    rows.add({run.cells, run.across, run.stiffness, run.speed, bars.bodies().dt(), figures.touching,
              figures.duration, figures.restitution, figures.vibration, seen.momentum / momentum,
              seen.depth / block_cell, std::move(status)});
  };
  if (seen.status != Status::ok) return add({}, std::string(to_string(seen.status)));
  if (!seen.left) return add({}, "never_left");
  const BarFigures figures{.touching = *seen.left / exact,
                           .duration = 2 * seen.moment / seen.impulse / exact,
                           .restitution = (bars.velocity(1) - bars.velocity(0)) / speed,
                           .vibration = bars.vibration() / energy};
  add(figures, judge(run, figures, seen.momentum / momentum));
}

namespace {

/// Two cubes of four cells that come together along z, with a quarter of a cell between them.
constexpr double closing_speed = 0.5, block_gap = 0.25 * block_cell;  // [m/s], [m]
constexpr int block_cells = 4;

/// How long they are watched [s]: a contact lasts some 3 L / c.
double watched() {
  const double length = block_cells * block_cell, c = std::sqrt(rubber.young / density);
  return 2 * block_gap / closing_speed + 8 * length / c;
}

/// The upper one is turned and set above the lower one.
TouchingBodies meeting_blocks(const BalanceRun& run) {
  const double length = block_cells * block_cell;
  const VoxelGrid cube = VoxelGrid::box(block_cells, block_cells, block_cells);
  TouchingBodies bodies({block_of(cube, Vec3::Zero()), block_of(cube, {0, 0, length})},
                        {.contact = {.bodies = true, .friction = run.friction}}, run.integrator, run.share);
  const Level& upper = bodies.levels()[1];
  const Vec3 centre = bodies.mean(1, bodies.state().x);
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  if (run.meeting == Meeting::corner)
    turn = Eigen::Quaterniond::FromTwoVectors(Vec3(1, 0.9, 1.2), Vec3::UnitZ());
  Vec3 by(0.013, 0.007, block_gap);
  if (run.meeting == Meeting::edge) by[0] = 0.5 * length;
  double lowest = std::numeric_limits<double>::infinity();
  for (const std::ptrdiff_t own : upper.body.sites())
    lowest = std::min(lowest, (turn * (bodies.state().x.at(upper.first + own) - centre))[2]);
  by[2] -= lowest + length / 2;
  for (const std::ptrdiff_t own : upper.body.sites()) {
    const std::ptrdiff_t site = upper.first + own;
    bodies.state().x.set(site, centre + by + turn * (bodies.state().x.at(site) - centre));
  }
  const Vec3 aslant(run.meeting == Meeting::corner ? 0.1 : 0.2, -0.1, 0);  // so that there is friction
  bodies.push(0, Vec3(0, 0, closing_speed / 2));
  bodies.push(1, Vec3(0, 0, -closing_speed / 2) + aslant);
  return bodies;
}

/// Sums over all particles.
struct Motions {
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
  double all_momentum = 0, all_angular = 0;  ///< of the particles' amounts
};
Motions motions_of(TouchingBodies& bodies) {
  Motions sum;
  for (const Level& level : bodies.levels())
    for (const std::ptrdiff_t own : level.body.sites()) {
      const Vec3 p = level.body.mass(own) * bodies.state().v.at(level.first + own),
                 l = bodies.state().x.at(level.first + own).cross(p);
      sum.momentum += p, sum.angular += l;
      sum.all_momentum += p.norm(), sum.all_angular += l.norm();
    }
  return sum;
}

/// What is measured of blocks.
struct Balance {
  Status status = Status::ok;
  long steps = 0, touching = 0;
  double momentum = 0, angular = 0;          ///< largest change in a step, over the amounts at the beginning
  double highest = 0, lowest = 0, last = 0;  ///< energy over the initial one, less 1
};

Balance watch(TouchingBodies& bodies) {
  Balance seen;
  const Motions first = motions_of(bodies);
  const double energy = bodies.energy();
  Motions before = first;
  while (bodies.state().t < watched()) {
    seen.status = bodies.step();
    if (seen.status != Status::ok) break;
    ++seen.steps;
    const Motions now = motions_of(bodies);
    seen.momentum = std::max(seen.momentum, (now.momentum - before.momentum).norm() / first.all_momentum);
    seen.angular = std::max(seen.angular, (now.angular - before.angular).norm() / first.all_angular);
    seen.last = bodies.energy() / energy - 1;
    seen.highest = std::max(seen.highest, seen.last);
    seen.lowest = std::min(seen.lowest, seen.last);
    if (bodies.system().contact_at(bodies.state())->touches > 0) ++seen.touching;
    before = now;
  }
  return seen;
}

const char* judge(const BalanceRun& run, const Balance& seen) {
  constexpr double most_change = 1e-12, most_gain = 1e-3;
  if (seen.touching == 0) return "never_met";
  const bool keeps = seen.momentum <= most_change && seen.angular <= most_change;
  const bool balances = seen.highest <= most_gain && (run.friction > 0 || seen.lowest >= -most_gain);
  return keeps && balances ? "ok" : "off";
}

}  // namespace

const char* to_string(Meeting meeting) {
  switch (meeting) {
    case Meeting::faces:
      return "face on face";
    case Meeting::edge:
      return "off the edge";
    case Meeting::corner:
      return "a corner first";
  }
  return "";
}

std::string BalanceRun::name() const {
  return fmt::format("blocks, {}, friction {:g}, {} at {:g}", to_string(meeting), friction, integrator,
                     share);
}

Table empty_balance() {
  return Table({{"meeting"},
                {"friction"},
                {"integrator"},
                {"share_of_safe_step"},
                {"dt", "s"},
                {"steps"},
                {"steps_touching"},
                {"momentum_change"},
                {"angular_momentum_change"},
                {"energy_highest"},
                {"energy_lowest"},
                {"energy_end"},
                {"status"}});
}

void add_balance_run(const BalanceRun& run, Table& rows) {
  TouchingBodies bodies = meeting_blocks(run);
  const Balance seen = watch(bodies);
  rows.add({std::string(to_string(run.meeting)), run.friction, run.integrator, run.share, bodies.dt(),
            std::int64_t(seen.steps), std::int64_t(seen.touching), seen.momentum, seen.angular, seen.highest,
            seen.lowest, seen.last,
            std::string(seen.status == Status::ok ? judge(run, seen) : to_string(seen.status))});
}

CollisionConfig collision_config(bool quick) {
  CollisionConfig config;
  for (const int across : quick ? std::vector{1} : std::vector{1, 2})
    for (const int cells : {20, 40})
      for (const double stiffness : {1.0, 4.0})
        for (const double speed : {0.001, 0.002, 0.005, 0.01, 0.02})
          if (!quick || speed == claimed_speed) config.bars.push_back({cells, across, stiffness, speed});
  for (const Meeting meeting : {Meeting::faces, Meeting::edge, Meeting::corner})
    for (const double friction : {0.0, 0.4}) {
      config.blocks.push_back({meeting, friction});
      if (quick) continue;
      config.blocks.push_back({.meeting = meeting, .friction = friction, .share = 0.25});
      config.blocks.push_back({meeting, friction, "pefrl"});
    }
  return config;
}

}  // namespace mss::studies::contact
