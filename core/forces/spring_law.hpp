#pragma once

// The law of springs: force, stiffness and energy by length, for the sweep, tangents, energies, XPBD and
// vertex block descent alike. A law is a file of forces/spring_laws/ that defines SpringLaw; the program is
// built for the one that the CMake variable MSS_SPRING_LAW names. With k the stiffness at rest, L the length,
// L0 that at rest and e = L / L0 - 1, it has
//   name, is_linear                          whether T is k (L - L0)
//   secant(e)    T = k (L - L0) secant       the tension
//   tangent(e)   dT / dL = k tangent         its derivative: secant + e secant'
//   energy(e)    W = k (L - L0)^2 energy / 2 the integral of T
// for numbers and for vectors of them, so without branches. secant and energy must stay positive. What comes
// from stiffness at rest, as safe steps and constant matrices do, is right for small strains alone.

#include MSS_SPRING_LAW_FILE

namespace mss {

/// e, from L0 / L.
template <class Number>
MSS_INLINE Number strain_of_ratio(Number ratio) {
  return constant<Number>(1) / ratio - constant<Number>(1);
}

/// e.
inline double spring_strain(double length, double rest_length) { return length / rest_length - 1; }

/// dT / dL.
template <class Number, class Stiffness>
MSS_INLINE Number spring_stiffness(Stiffness k, Number ratio) {
  return k * SpringLaw::tangent(strain_of_ratio(ratio));
}

/// T / L, from the ratio L0 / L.
template <class Number, class Stiffness>
MSS_INLINE Number tension_over_length(Stiffness k, Number ratio) {
  return (k * (constant<Number>(1) - ratio)) * SpringLaw::secant(strain_of_ratio(ratio));
}

/// T / L, from r = 1 / L in any unit, and k L0 and L0 in that unit: it costs one operation less.
template <class Number, class Stiffness>
MSS_INLINE Number tension_over_length(Stiffness k, Stiffness k_rest, Scalar<Number> rest_length, Number r) {
  return (k - r * k_rest) * SpringLaw::secant(strain_of_ratio(rest_length * r));
}

/// The same with a damper's force `drag`: T / L + r drag.
template <class Number, class Stiffness>
MSS_INLINE Number tension_over_length(Stiffness k, Stiffness k_rest, Scalar<Number> rest_length, Number r,
                                      Number drag) {
  const Number secant = SpringLaw::secant(strain_of_ratio(rest_length * r));
  return k * secant + r * (drag - k_rest * secant);
}

/// L0 - L, from L^2 and r = 1 / L.
template <class Number>
MSS_INLINE Number spring_shortening(Scalar<Number> rest_length, Number squared, Number r) {
  return rest_length - squared * r;
}

/// What the law does to a projection of L0 - L that is k g times it, g = 1 / (1 + k m): T over 1 + m dT/dL.
/// `kmg` is k m g, m the spring's mobility.
template <class Number>
MSS_INLINE Number projection_factor(Number ratio, Number kmg) {
  if constexpr (SpringLaw::is_linear) {
    return constant<Number>(1);
  } else {
    const Number e = strain_of_ratio(ratio), one = constant<Number>(1);
    return one / (one + (SpringLaw::tangent(e) - one) * kmg);
  }
}

/// W [J].
inline double spring_energy(double k, double rest_length, double length) {
  const double change = length - rest_length;
  return 0.5 * k * change * change * SpringLaw::energy(spring_strain(length, rest_length));
}

/// What a law's tension is beside Hooke's, over k.
inline double excess_tension(double rest_length, double length) {
  return (SpringLaw::secant(spring_strain(length, rest_length)) - 1) * (length - rest_length);
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
