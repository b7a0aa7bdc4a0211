#pragma once

#include <array>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/body.hpp"
#include "core/scene.hpp"
#include "integrators/integrator.hpp"

namespace mss::advise {

/// What two motions of one scene are compared by.
enum class ErrorOf {
  displacement,  ///< of points, root mean square over them, over the largest of the reference
  volume,        ///< over the volume at rest
  frequency,     ///< of the reference's largest motion, over itself
  energy         ///< gained since the start, over the largest that the reference moves and stores
};
/// As options spell them, in the enumeration's order.
const std::vector<std::string>& error_names();

/// What is seen of a scene at looks evenly apart, the first at its start. Where a step leads past a look,
/// nothing is seen of it.
struct Trajectory {
  struct Look {
    std::vector<Vec3> displacement{};  ///< of the points looked at [m]; empty: not seen
    double volume_ratio = 1;
    double energy = 0;   ///< of everything, the start's taken off [J]
    double holding = 0;  ///< kinetic and stored [J]
  };
  std::vector<Look> looks;
};

/// A reference that motions are judged by.
class Judge {
 public:
  Judge(ErrorOf of, Trajectory reference);

  const Trajectory& reference() const { return reference_; }
  /// What errors are shares of; 0 if the reference does not move at all, NaN if it has no frequency.
  double scale() const { return scale_; }

  /// Whether an error can be told before the end: the frequency's cannot.
  bool sees_early() const { return of_ != ErrorOf::frequency; }
  /// Error at one look that was seen.
  double at(const Trajectory& trajectory, std::size_t look) const;
  /// Of all looks there are. NaN if the trajectory has no frequency.
  double over_all(const Trajectory& trajectory) const;

 private:
  double frequency(const Trajectory& trajectory) const;

  ErrorOf of_;
  Trajectory reference_;
  double scale_ = 1;
  std::vector<Vec3> shape_;  ///< of the largest motion
};

/// What a trajectory tends to as its error falls with the square of the cells' size, from two of which the
/// second has cells smaller by a factor.
Trajectory extrapolate(const Trajectory& coarse, const Trajectory& fine, double factor);

/// Where a run is looked at, and when.
struct Looks {
  std::vector<Vec3> points;  ///< at rest [m]
  double interval = 0;       ///< [s]
  int count = 0;             ///< after the start
  ErrorOf of{};              ///< volume and energies are not seen unless it is of them
};
/// Particles of a scene as it stands, at most a few hundred, and its duration's parts.
Looks looks_of(const Scene& scene, ErrorOf of);

/// The longest step up to `most` that meets looks, the last of them too [s].
double step_between_looks(double most, const Looks& looks);

/// How a run ended.
struct Followed {
  Status status = Status::ok;
  Trajectory trajectory;
  std::vector<double> seconds{};  ///< of stepping, from one look that was seen to the next
  double simulated = 0;           ///< [s]
  bool ended_early = false;

  /// Of stepping so far.
  double total_seconds() const;
  /// Seconds of stepping per simulated second; what took several times as long as most does not count in
  /// full, because somebody else had the core.
  double cost() const;
};
/// Runs a scene; `go_on` is asked after every look that was seen. It also ends where it takes longer than
/// `most_seconds` from look to look, or an adaptive method takes more than 512 steps.
Followed follow_scene(const Scene& scene, const Looks& looks,
                      const std::function<bool(const Followed&)>& go_on,
                      double most_seconds = std::numeric_limits<double>::infinity());

}  // namespace mss::advise
