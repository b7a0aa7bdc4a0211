#pragma once

#include <string>
#include <vector>

#include "core/measures/measures.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/peer/result.hpp"

namespace mss::peer {

/// What measures are relative to, and which of them a scene has.
struct Scale {
  double displacement = 0;  ///< largest of the reference, from the start [m]
  double size = 0;          ///< diagonal of the body's box at rest [m]
  double momentum = 0;      ///< sqrt(2 M K) of the reference's largest kinetic energy K [kg m/s]
  double spin = 0;          ///< angular momentum at the start [kg m^2/s]; 0: it does not turn
  double energy = 0;        ///< largest sum of kinetic and stored energy of the reference [J]
  /// Samples, from the first on, until which nothing but gravity and loads has acted on a free body; 0 of a
  /// held one.
  std::size_t free_samples = 0;
  bool has_holds = false, has_planes = false;
  bool has_momentum = false;  ///< it moves freely for a while
  bool has_spin = false;      ///< turning, without loads
  bool has_energy = false;    ///< its model has an energy
  std::string takes_energy;   ///< what takes energy of the reference, in words; empty: nothing does
};

/// What a result is worth. Numbers that it or its scene do not have are NaN.
struct Score {
  std::string status = "ok";  ///< or what is wrong with the result, in words
  bool stable = false;        ///< all samples are there, finite and not blown up
  /// The motion blew up; neither: the samples are at fault, or the program gave up for another reason.
  bool unstable = false;
  /// Distance from the reference over its largest displacement: root mean square over particles and sample
  /// times, and largest.
  double error = no_value, worst_error = no_value;
  double volume_low = no_value, volume_high = no_value;  ///< extremes of volume over that at rest
  double volume_drift = no_value;  ///< largest distance of that ratio from the reference's
  double min_jacobian = no_value;  ///< smallest: 0 or less where a cell is folded
  /// Largest distances from the reference's momentum and angular momentum, over Scale::momentum and
  /// Scale::spin, while the body is free.
  double momentum_drift = no_value, spin_drift = no_value;
  double penetration = no_value;  ///< deepest behind a plane [m]
  double held_drift = no_value;   ///< largest of held particles from their places [m]
  /// Most that kinetic, stored and outer potential energy together are above and below the reference's, over
  /// Scale::energy.
  double energy_gain = no_value, energy_loss = no_value;
  /// Of stepping, per frame of 1/60 s [ms]; 0: the program gives none.
  double cpu_ms = no_value, wall_ms = no_value;
};

/// What of a body keeps, at a sample or between two.
struct Balance {
  double energy = 0;                                  ///< [J]
  Vec3 momentum = Vec3::Zero(), spin = Vec3::Zero();  ///< [kg m/s], about the centre of mass [kg m^2/s]
};

/// Judges results of one scene against its reference. Velocities are those of a result, or where it has none
/// differences of its samples, which are compared with differences of the reference's.
class Judge {
 public:
  /// The exchange must outlive it, and have a reference. Throws InputError if that does not move.
  explicit Judge(const Exchange& exchange);

  const Exchange& exchange() const { return exchange_; }
  const Scale& scale() const { return scale_; }
  Score score(const Result& result) const;

 private:
  void find_scale();
  std::size_t count_free_samples() const;
  void add_distances(const Result& result, Score& score) const;
  void add_volumes(const std::vector<Measures>& measures, Score& score) const;
  void add_balances(const std::vector<Balance>& now, const std::vector<Balance>& reference,
                    Score& score) const;
  std::string blow_up(const Result& result, const std::vector<Measures>& measures) const;

  const Exchange& exchange_;
  std::vector<Measures> reference_;  ///< by sample
  std::vector<Balance> at_samples_, between_samples_;
  Scale scale_;
};

}  // namespace mss::peer
