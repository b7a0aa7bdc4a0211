#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/harness/table.hpp"
#include "experiments/peer/result.hpp"

namespace mss::peer {

/// What measures of a scene mean anything, and what they are relative to.
struct Scale {
  double displacement = 0;  ///< largest of the reference, from the start [m]
  double momentum = 0;      ///< sqrt(2 M K) of the reference's largest kinetic energy K [kg m/s]
  double spin = 0;          ///< angular momentum at the start [kg m^2/s]; 0: it does not turn
  double kinetic = 0;       ///< largest of the reference [J]
  double energy = 0;        ///< largest kinetic and stored energy of the reference [J]
  /// Samples, from the first on, at which nothing but gravity and loads acts on a free body; 0: held.
  std::size_t free_samples = 0;
  bool has_planes = false, has_holds = false;
  std::string takes_energy;  ///< what takes energy from the body, in words; empty: nothing does
};

/// What a result is worth; NaN where it has no such number.
struct Score {
  std::string status = "ok";  ///< or what is wrong with the result, in words
  bool stable = false;        ///< all samples are there, finite and not blown up
  double error = no_value;    ///< distance from the reference over the largest displacement: root mean square
                              ///< over particles and times,
  double worst_error = no_value;  ///< and largest
  double volume_low = no_value;   ///< extremes of volume over that at rest
  double volume_high = no_value;
  double volume_drift = no_value;      ///< largest distance of that from the reference's
  double min_jacobian = no_value;      ///< smallest: 0 or less where it folds
  double momentum_drift = no_value;    ///< of a free body, over Scale::momentum
  double spin_drift = no_value;        ///< of a free body that turns, over Scale::spin
  double penetration = no_value;       ///< deepest behind a plane [m]
  double held_drift = no_value;        ///< of held particles from their places [m]
  double energy_gain = no_value;       ///< most above the reference's, over Scale::energy
  double energy_loss = no_value;       ///< most below
  double cpu_ms_per_frame = no_value;  ///< of 1/60 s
  double wall_ms_per_frame = no_value;
};

/// Judges results of one scene. The exchange, with its reference, must outlive it.
class Judge {
 public:
  explicit Judge(const Exchange& exchange);

  const Scale& scale() const { return scale_; }
  const Exchange& exchange() const { return exchange_; }
  Score score(const Result& result) const;

 private:
  struct Moments;  ///< of a motion, by sample

  const Exchange& exchange_;
  Scale scale_;
};

}  // namespace mss::peer
