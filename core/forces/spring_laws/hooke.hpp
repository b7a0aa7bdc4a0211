#pragma once

#include "core/base/kernel_number.hpp"

namespace mss {

/// T = k (L - L0). What a law has is described in core/forces/spring_law.hpp.
struct SpringLaw {
  static constexpr const char* name = "hooke";
  static constexpr bool is_linear = true;

  template <class Number>
  MSS_INLINE static Number secant(Number) {
    return constant<Number>(1);
  }
  template <class Number>
  MSS_INLINE static Number tangent(Number) {
    return constant<Number>(1);
  }
  template <class Number>
  MSS_INLINE static Number energy(Number) {
    return constant<Number>(1);
  }
};

}  // namespace mss
