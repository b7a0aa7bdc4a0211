#pragma once

#include <cmath>

namespace mss {

/// A standard linear solid: beside every spring a Maxwell branch, a spring of `ratio` times its stiffness k
/// in series with a damper. Strained at once, springs are 1 + ratio times as stiff as at rest; at constant
/// length the branch's tension q decays as exp(-t / time). With L the length of the spring,
///   q' = ratio k L' - q / time.
/// What a body of volume force has beside springs does not relax.
struct Relaxation {
  double ratio = 0;  ///< stiffness at once over that at rest, less one
  double time = 0;   ///< [s]

  bool acts() const { return ratio > 0; }
};

/// The exact solution of the branch while its spring's length changes at a constant rate for some time:
///   q(t + dt) = decay q(t) + gain ratio k (L(t + dt) - L(t)),
/// decay = exp(-h), gain = (1 - exp(-h)) / h, h = dt / time: so a step has no limit of the branch's own.
/// Simo and Hughes, Computational Inelasticity, 10.3.
struct BranchStep {
  double h, decay, gain;

  /// `dt` may be infinite: then nothing is left.
  BranchStep(const Relaxation& relaxation, double dt)
      : h(dt / relaxation.time), decay(std::exp(-h)), gain(h > 0 ? -std::expm1(-h) / h : 1) {}

  /// What the damper dissipates meanwhile, times the branch's stiffness [N^2]: the integral of q^2 / time,
  /// from q before and `pull`, the branch's stiffness times the change of length.
  double dissipated(double q, double pull) const {
    if (!(h < infinite)) return 0;
    const double lost = -std::expm1(-h);
    const double of_both = h > 0 ? lost * lost / h : 0;
    const double of_pull = h < short_step
                               ? h * (1 / 3.0 - h * (1 / 4.0 - h * (7 / 60.0 - h / 24)))  // no cancellation
                               : (h - lost * (3 - decay) / 2) / (h * h);
    return -std::expm1(-2 * h) / 2 * q * q + of_both * q * pull + of_pull * pull * pull;
  }

 private:
  static constexpr double short_step = 1e-2, infinite = 1e300;
};

}  // namespace mss
