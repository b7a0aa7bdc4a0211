#pragma once

#include "core/body/spectral_bound.hpp"
#include "core/environment/environment.hpp"
#include "core/environment/obstacle.hpp"
#include "core/system/system.hpp"

namespace mss {

/// Position [m] and velocity [m/s] of one particle.
struct Motion {
  Vec3 x, v;
};

/// The contact law `impulse`. A step of dt has taken a particle from `before` to `after` without the plane;
/// corrects `after` for it. False if nothing changes.
///
/// The path in between is taken as the parabola through both positions with the step's acceleration,
/// (v' - v) / dt; so the time and speed of impact are right for every method that integrates a constant
/// acceleration exactly, also for those whose velocities lag by half a step. At the impact the particle gets
/// an impulse of (1 + e) times that speed along the normal, and of at most mu times as much against its
/// sliding. Rebounds shorter than a step count as resting contact: the particle then lies on the plane,
/// without normal velocity, and the impulse is the one that stops it.
bool collide_impulse(const Plane& plane, const Motion& before, double dt, Motion& after);

/// Speed at which planes push out what began behind them, in cells of the body's a second: a body is lifted,
/// not thrown.
inline constexpr double push_out_rate = 2;
/// Of a cell's size: what is less far behind is there by rounding.
inline constexpr double behind_by_rounding = 1e-4;

/// How far behind a plane a step may leave what began it there, as a gap [m]: it is pushed out at a speed
/// [m/s], instead of at once; 0 for what began it in front, but for `close` [m].
double push_out_gap(const Plane& plane, const Vec3& before, double speed, double dt, double close);

/// A particle that began a step behind a plane: moves it that far out, and stops what moves it in. False if
/// nothing changes.
bool push_out(const Plane& plane, double gap, Motion& after);

/// How a method takes free particles through a step: v' = v + dt g, x' = x + dt v + drift dt^2 g.
struct FreeStep {
  double dt;     ///< [s]
  double drift;  ///< 1/2 where that is exact
};

/// Ends a step within which a plane has stopped a particle as the law `impulse` has it: it leaves as if it
/// had come freely, with that speed, less what friction takes of its sliding meanwhile, and from where it
/// would be then. If it came no faster than gravity makes it in two steps, or unless it `may_leave`, it
/// rests. True if it leaves.
bool rebound(const Plane& plane, const Vec3& gravity, const FreeStep& step, bool may_leave,
             const Motion& before, Motion& after);

/// What an obstacle's surface does in a step of dt to a particle that its plane stops, by the law of the
/// plane: seen from the point that is touched, whose motion is straight, the plane rests. `gap`: that of the
/// particle where it began the step [m]; what began behind is pushed out at a speed [m/s], but for `close`
/// [m], or all at once if that is infinite. False if nothing changes.
struct PushOut {
  double speed, close;
};
bool collide_moving(const MovingPlane& met, double gap, const PushOut& out, const Motion& before, double dt,
                    Motion& after);

/// Whether a particle at rest sticks to a plane of that law: it lies on it, within `close` [m], and the
/// acceleration it would have without the plane points into the plane and lies inside Coulomb's cone.
bool sticks(const Plane& plane, const Motion& motion, const Vec3& acceleration, double close);

/// The contact law `thesis`, Algorithm 2, with x + v dt for x + v and the step's own end for that: a particle
/// that crosses the plane is mirrored, and all of its velocity reflected and multiplied by the restitution.
/// If it is slow, no faster than two steps of its acceleration would make it, it is moved to where it
/// crossed, its velocity is zeroed, and the support N and the friction mu N, against what pulls it along the
/// plane, act on it for a step. Products f(x) f(x') of zero count only for approaching particles: otherwise a
/// separating particle would be reflected below the plane. A particle that is behind the plane stays there,
/// as printed.
bool collide_thesis(const Plane& plane, const Motion& before, Motion& after);

/// The contact law `penalty`: a smooth force, per unit of mass, on particles at a depth d = -gap behind a
/// plane,
///   p n + t,  p = N(d) + D(n.v, r N),  t = D(tangential v, mu p),
///   N(d) = omega^2 d^2 / (2 l) for d <= l, omega^2 (d - l / 2) beyond,
///   D(v, L) = -L v / sqrt(v^2 + (L / rate)^2):
/// a one-sided spring that is linear but for its first l, where its slope starts at zero; rate-independent
/// losses of normal motion, r = (1 - e^2) / (1 + e^2), so that a collision returns e^2 of its energy; and
/// Coulomb friction. Both losses are viscous, with that rate, below the speed L / rate, so a body on a slope
/// creeps.
class Penalty {
 public:
  /// `body`: the spectrum of what collides; the spring is as stiff as its fastest mode, or, where gravity
  /// [m/s^2] would press a single particle deeper than l that way, stiff enough. l is a hundredth of a cell.
  Penalty(const Plane& plane, const SpectralBound& body, double gravity, double cell_size);

  /// The same law on another plane of the same restitution and friction, which may move: losses are of
  /// velocities relative to it.
  Penalty on(const MovingPlane& other) const;

  double gap(const Vec3& x) const { return plane_.gap(x); }

  /// Force over mass [m/s^2].
  Vec3 acceleration(const Motion& motion) const;

  /// b C + c K of a sum, over mass. Without the turning of an obstacle's normal along it, a depth over a
  /// radius of what is there. The exact one contains the change of friction with pressure, which is
  /// unsymmetric; the others are symmetric and positive semidefinite.
  Eigen::Matrix3d tangent(const Motion& motion, const TangentCoefficients& sum) const;

  /// Energy of the spring over mass [m^2/s^2].
  double potential(const Vec3& x) const;

  /// The most that it adds to the spectrum: omega^2 to the squared frequencies, and damping.
  SpectralBound bound() const;

 private:
  struct Parts;
  Parts parts(const Motion& motion) const;

  Plane plane_;
  Vec3 velocity_ = Vec3::Zero();  ///< of the plane [m/s]
  double omega_;                  ///< [rad/s]
  double layer_;                  ///< l [m]
  double loss_;                   ///< r
  double rate_;                   ///< [1/s]
};

/// Splits what planes give one particle together by plane: along their normals as these make it up, the rest
/// in proportion to the friction that their pressures allow, or, if they allow none, in equal parts. `on`:
/// indices of the planes that touch it; `free`: 1 along axes that nothing prescribes. Zero for other planes.
std::vector<Vec3> split_by_plane(const std::vector<Plane>& planes, const std::vector<std::size_t>& on,
                                 const Vec3& free, const Vec3& given);

}  // namespace mss
