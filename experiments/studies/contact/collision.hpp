#pragma once

#include <string>
#include <vector>

#include "experiments/harness/table.hpp"
#include "experiments/plot/chart.hpp"

namespace mss::studies::contact {

/// A bar that hits an equal one at rest, end on end, with lateral motion held.
struct BarRun {
  int cells = 20;
  int across = 1;
  double stiffness = 1;  ///< of contact
  double speed = 0.01;   ///< over that of waves along the bar
  std::string name() const;
};

/// How two blocks meet.
enum class Meeting {
  faces,  ///< squarely
  edge,   ///< beside each other by half, turning after it
  corner  ///< one turned so that a corner comes first
};
const char* to_string(Meeting meeting);

/// Two blocks that hit each other in free space.
struct BalanceRun {
  Meeting meeting{};
  double friction = 0;
  std::string integrator = "velocity_verlet";  ///< with velocities of the positions' time
  double share = 0.5;                          ///< of the safe step
  std::string name() const;
};

/// What `mss validate contact` computes of bodies that hit each other.
struct CollisionConfig {
  std::vector<BarRun> bars{};
  std::vector<BalanceRun> blocks{};
};
CollisionConfig collision_config(bool quick);

Table empty_bars();
/// The exact solution: they part after 2 L / c, in which a wave runs along a bar and back, with their
/// velocities exchanged and nothing left vibrating. `duration_over_exact` is twice the mean time of the
/// impulse, which a constant force has as its duration; `touching_over_exact` from the first touch to the
/// last, which may be a light one. Of duration, restitution and vibration left, over the first energy, 4
/// percent, .95 and 4 percent are allowed at 20 cells, and 2 percent, .97 and 2.5 percent at 40, at a
/// hundredth of c. The status is `ok`; `off` where one is missed; `not_claimed` at other speeds;
/// `never_left`; or how the method ended.
void add_bar_run(const BarRun& run, Table& rows);

Table empty_balance();
/// Momentum and angular momentum may change in a step by 1e-12 of the sum of the particles' amounts. Energy,
/// over the initial one, may never rise by more than a thousandth, nor fall by more without friction. The
/// status is `ok`, `off`, `never_met`, or how the method ended.
void add_balance_run(const BalanceRun& run, Table& rows);

/// Worst figures, a line each.
std::string collision_summary(const Table& bars, const Table& balance);

/// The duration by speed, cells and stiffness.
Chart bars_chart(const Table& rows);

}  // namespace mss::studies::contact
