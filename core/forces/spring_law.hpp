#pragma once

// The law of springs: force, stiffness and energy by length, for the sweep, tangents, energies, XPBD and
// vertex block descent alike, on the processor and on devices. A law is a file of forces/spring_laws/; the
// program is built for the one that the CMake variable MSS_SPRING_LAW names. With k the stiffness at rest, L
// the length, L0 that at rest and e = L / L0 - 1, it has
//   MSS_SPRING_LAW(name, is_linear)             whether T is k (L - L0)
//   law_secant(e)    T = k (L - L0) law_secant  the tension
//   law_tangent(e)   dT / dL = k law_tangent    its derivative: law_secant + e law_secant'
//   law_energy(e)    W = k (L - L0)^2 law_energy / 2   the integral of T
// as formulas (core/base/formula.hpp) for numbers and for vectors of them, so without branches. law_secant
// and law_energy must stay positive. What comes from stiffness at rest, as safe steps and constant matrices
// do, is right for small strains alone.

#include "core/base/formula.hpp"

namespace mss {

#include MSS_SPRING_LAW_FILE

inline constexpr bool law_is_linear = SpringLaw::is_linear;

#include "core/forces/spring_formulas.inc"

/// e.
inline double spring_strain(double length, double rest_length) { return length / rest_length - 1; }

/// W [J].
inline double spring_energy(double k, double rest_length, double length) {
  const double change = length - rest_length;
  return 0.5 * k * change * change * law_energy(spring_strain(length, rest_length));
}

/// What a law's tension is beside Hooke's, over k.
inline double excess_tension(double rest_length, double length) {
  return (law_secant(spring_strain(length, rest_length)) - 1) * (length - rest_length);
}

/// The discrete gradient of W: (W1 - W0) / (L1 - L0) over the mean length, less T / L at the length `middle`
/// of the mean difference of ends. Means of T by three points of Gauss, which are exact for fifth powers.
inline double discrete_gradient_correction(double k, double rest_length, double middle, double length0,
                                           double length1, double shortest) {
  const double mean = (length0 + length1) / 2 > shortest ? (length0 + length1) / 2 : shortest;
  const double half = 0.3872983346207417 * (length1 - length0);  // sqrt(3/5) / 2
  const double excess =
      (5 * excess_tension(rest_length, mean - half) + 8 * excess_tension(rest_length, mean) +
       5 * excess_tension(rest_length, mean + half)) /
      18;
  return k * rest_length * (1 / middle - 1 / mean) +
         k * (excess / mean - excess_tension(rest_length, middle) / middle);
}

}  // namespace mss
