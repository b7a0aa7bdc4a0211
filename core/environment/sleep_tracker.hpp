#pragma once

#include <functional>
#include <vector>

#include "core/base/lattice.hpp"
#include "core/base/state.hpp"

namespace mss {

class Record;

/// When particles that hardly move are no longer computed.
struct SleepRule {
  double bound = 0;    ///< how far they may be from where they would be otherwise [m]; 0: nothing sleeps
  double after = 0.5;  ///< how long they must have rested [s]
};

/// Which planes of a body's particles sleep: those keep their positions, and cells between two of them are
/// not computed.
///
/// A plane rests that has stayed within a quarter of the bound of where it was for as long as the rule says;
/// it falls asleep if its neighbours, three on either side, rest or sleep too. It wakes before the step in
/// which one of them leaves that quarter, or at wake_moving() if it has been given a velocity. Motion slower
/// than a quarter of the bound in that time counts as rest and is stopped: a vibration at its turning point
/// is resumed when the plane wakes, a creeping motion is not, and the error then exceeds the bound.
template <class Real>
class SleepTracker {
 public:
  /// Whether a plane is moved from outside, by a hold.
  using IsDriven = std::function<bool(int plane)>;

  SleepTracker(const Lattice& lattice, const SleepRule& rule);

  bool asleep(int plane) const { return asleep_[std::size_t(plane)] != 0; }
  bool all_asleep() const { return sleeping_ == planes(); }
  double share_asleep() const { return double(sleeping_) / planes(); }
  /// Whether the cells between a plane and the next act on a plane that is awake.
  bool needs_cells(int plane) const { return !asleep(plane) || (plane + 1 < planes() && !asleep(plane + 1)); }

  /// To be called after every step. True if a plane fell asleep, and lost its velocity, or woke.
  bool update(State<Real>& state, const IsDriven& is_driven);

  /// Wakes planes where velocities are not zero, and their neighbours.
  void wake_moving(const State<Real>& state);
  /// Wakes all planes; none has rested yet.
  void wake_all();
  /// See core/base/record.hpp.
  void remember(Record& record);

 private:
  int planes() const { return int(asleep_.size()); }
  bool moves(int plane, const State<Real>& state, double step) const;
  void set_anchor(int plane, const State<Real>& state);
  bool may_sleep(int plane, double t) const;
  void fall_asleep(int plane, State<Real>& state);
  bool wake_around(int plane, double t);

  std::ptrdiff_t sites_;      ///< of a plane
  std::ptrdiff_t all_sites_;  ///< of fields
  double near_;               ///< [m]
  double after_;              ///< [s]
  std::vector<char> asleep_;
  int sleeping_ = 0;
  double updated_ = 0;                 ///< time of the last update [s]
  std::vector<double> resting_since_;  ///< [s]; of planes that are awake
  Field<Real> anchor_;                 ///< where they were then; empty before the first update
};

}  // namespace mss
