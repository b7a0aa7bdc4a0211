#pragma once

// Formulas in the words that C++ and GLSL have in common: the same text is compiled into the processor's
// kernels, for numbers and for vectors of them, and into a device's shaders, whose prelude
// (device/shaders/prelude.glsl) defines these words for one number. Such text is functions of values alone:
// no templates, references, casts or names with ::.

#include "core/base/kernel_number.hpp"

/// Before a function of `Number`s.
#define MSS_FORMULA       \
  template <class Number> \
  MSS_INLINE
/// Before one of `Number`s that a constant `Stiffness`, the same in all lanes or not, goes into.
#define MSS_FORMULA_WITH_STIFFNESS         \
  template <class Number, class Stiffness> \
  MSS_INLINE
/// Before one of `Vector`s of three.
#define MSS_VECTOR_FORMULA \
  template <class Vector>  \
  MSS_INLINE
/// Before a parameter that this law does not need.
#define MSS_UNUSED [[maybe_unused]]
/// A constant.
#define MSS_NUMBER(value) constant<Number>(value)
/// A number that is the same in all lanes.
#define MSS_SCALAR Scalar<Number>
/// What a law of springs says of itself, see forces/spring_law.hpp.
#define MSS_SPRING_LAW(law, linear)           \
  struct SpringLaw {                          \
    static constexpr const char* name = #law; \
    static constexpr bool is_linear = linear; \
  };
