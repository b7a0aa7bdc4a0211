#pragma once

#include <functional>
#include <vector>

#include "core/lattice.hpp"
#include "core/system.hpp"

namespace mss {

/// When particles that hardly move are no longer computed.
struct SleepRule {
  double bound = 0;    ///< how far they may be from where they would be otherwise [m]; 0: nothing sleeps
  double after = 0.5;  ///< how long they must have rested [s]
};

/// Which planes of a body's particles sleep: those keep their place, and cells between two of them cost
/// nothing.
///
/// A plane that has stayed within a quarter of the bound of where it was, for as long as the rule says,
/// rests; it sleeps if its neighbours, three on either side, rest or sleep too. It wakes before the step in
/// which one of them leaves that quarter, or when somebody gives it a velocity and says so. What moves more
/// slowly than a quarter of the bound in that time is taken for rest too, and stops: vibrations where they
/// turn come back to it, what creeps does not, and is left behind further than the bound.
template <class Real>
class Sleepers {
 public:
  /// Whether something moves a plane from outside, whatever it does itself.
  using Restless = std::function<bool(int plane)>;

  Sleepers(const Lattice& lattice, const SleepRule& rule);

  bool asleep(int plane) const { return asleep_[std::size_t(plane)] != 0; }
  bool all_asleep() const { return sleeping_ == planes(); }
  double share_asleep() const { return double(sleeping_) / planes(); }
  /// Whether the cells between a plane and the next matter to who is awake.
  bool needs_cells(int plane) const { return !asleep(plane) || (plane + 1 < planes() && !asleep(plane + 1)); }

  /// Ask after every step. True if somebody fell asleep, and lost their velocity, or woke.
  bool look(State<Real>& state, const Restless& restless);

  /// Wakes planes where velocities are not zero, and their neighbours.
  void wake_moving(const State<Real>& state);
  /// Everybody is awake, and has not rested yet.
  void wake_all();

 private:
  int planes() const { return int(asleep_.size()); }
  bool moves(int plane, const State<Real>& state, double step) const;
  void remember(int plane, const State<Real>& state);
  bool may_sleep(int plane, double t) const;
  void fall_asleep(int plane, State<Real>& state);
  bool wake_around(int plane, double t);

  std::ptrdiff_t sites_;  ///< of a plane
  double near_;           ///< [m]
  double after_;          ///< [s]
  std::vector<char> asleep_;
  int sleeping_ = 0;
  double looked_ = 0;                  ///< when [s]
  std::vector<double> resting_since_;  ///< [s]; of those awake
  Field<Real> anchor_;                 ///< where they were then; empty before the first look
};

}  // namespace mss
