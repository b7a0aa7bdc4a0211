#pragma once

// What formulas need that are written once for numbers and for vectors of numbers (`Pack` in
// kernels/simd.hpp). Included by loops that are compiled once per instruction set: nothing here may call an
// inline function of the standard library.

/// Before every function that such loops are made of: they are inlined into one, regardless of its size, so
/// that no loop ever calls a copy compiled for another instruction set. Not under sanitizers, which check
/// every access: each file of sweeps takes over eleven minutes then.
#if MSS_SANITIZED
#define MSS_INLINE inline
#else
#define MSS_INLINE [[gnu::always_inline]] inline
#endif

namespace mss {

/// float or double, of a number or of a vector of them.
template <class Number>
struct ScalarOf {
  template <class Pack>
  static auto element(Pack pack) -> decltype(pack[0] + pack[0]);
  using type = decltype(element(Number{}));
};
template <>
struct ScalarOf<float> {
  using type = float;
};
template <>
struct ScalarOf<double> {
  using type = double;
};
template <class Number>
using Scalar = typename ScalarOf<Number>::type;

/// A number, in all lanes if it is a vector.
template <class Number>
MSS_INLINE Number constant(double value) {
  return Number{} + static_cast<Scalar<Number>>(value);
}

}  // namespace mss
