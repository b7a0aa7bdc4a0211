#pragma once

// A thin layer over the vector extensions of GCC and Clang: arithmetic is the compiler's, this adds unaligned memory
// access, a lane shift and the reciprocal square root. Included only by the sweep, which is compiled once per
// instruction set; MSS_ISA names the namespace of that copy, so that the linker never mixes two of them. For the
// same reason nothing here may call an inline function of the standard library.

#include <cstddef>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace mss::MSS_ISA {

#if defined(__AVX512F__)
inline constexpr int vector_bytes = 64;
#elif defined(__AVX2__)
inline constexpr int vector_bytes = 32;
#else
inline constexpr int vector_bytes = 16;
#endif

template <class Real>
inline constexpr int lanes = vector_bytes / int(sizeof(Real));

template <class Real>
struct PackOf {
  typedef Real type __attribute__((vector_size(vector_bytes)));
  typedef Real unaligned __attribute__((vector_size(vector_bytes), aligned(alignof(Real)), may_alias));
};
template <class Real>
using Pack = typename PackOf<Real>::type;

template <class Real>
[[gnu::always_inline]] inline Pack<Real> load(const Real* p) {
  return *reinterpret_cast<const typename PackOf<Real>::unaligned*>(p);
}
template <class Real>
[[gnu::always_inline]] inline void store(Real* p, Pack<Real> v) {
  *reinterpret_cast<typename PackOf<Real>::unaligned*>(p) = v;
}

/// (previous[W-1], v[0], ..., v[W-2]): values that belong one lane further on, and the last of the block before.
[[gnu::always_inline]] inline Pack<double> shift_in(Pack<double> previous, Pack<double> v) {
#if defined(__AVX512F__)
  return __builtin_shufflevector(previous, v, 7, 8, 9, 10, 11, 12, 13, 14);
#elif defined(__AVX2__)
  return __builtin_shufflevector(previous, v, 3, 4, 5, 6);
#else
  return __builtin_shufflevector(previous, v, 1, 2);
#endif
}
[[gnu::always_inline]] inline Pack<float> shift_in(Pack<float> previous, Pack<float> v) {
#if defined(__AVX512F__)
  return __builtin_shufflevector(previous, v, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30);
#elif defined(__AVX2__)
  return __builtin_shufflevector(previous, v, 7, 8, 9, 10, 11, 12, 13, 14);
#else
  return __builtin_shufflevector(previous, v, 3, 4, 5, 6);
#endif
}

// Reciprocal square root: a hardware estimate y of 1/sqrt(a), then one correction from the series
//   1/sqrt(a) = y (1 - e)^(-1/2) = y (1 + e/2 + 3/8 e^2 + 5/16 e^3 + 35/128 e^4 + ...),  e = 1 - a y^2.
// The estimate is good to 1.5 2^-12 (2^-14 with AVX-512), so |e| < 7.4e-4 (1.3e-4) and the terms kept leave
// 6e-17 in double and 2e-10 in single: below rounding, where square root and division would cost
// 1.5 times the whole spring.
[[gnu::always_inline]] inline Pack<double> rsqrt(Pack<double> a) {
#if defined(__AVX512F__)
  const Pack<double> y = _mm512_maskz_rsqrt14_pd(0xFF, a);  // the unmasked form makes GCC 12 warn
  const Pack<double> e = 1.0 - a * y * y;
  const Pack<double> series = (5.0 / 16 * e + 3.0 / 8) * e + 0.5;
#elif defined(__AVX2__)
  const Pack<double> y = _mm256_cvtps_pd(_mm_rsqrt_ps(_mm256_cvtpd_ps(a)));
  const Pack<double> e = 1.0 - a * y * y;
  const Pack<double> series = ((35.0 / 128 * e + 5.0 / 16) * e + 3.0 / 8) * e + 0.5;
#elif defined(__x86_64__)
  const Pack<double> y = _mm_cvtps_pd(_mm_rsqrt_ps(_mm_cvtpd_ps(a)));
  const Pack<double> e = 1.0 - a * y * y;
  const Pack<double> series = ((35.0 / 128 * e + 5.0 / 16) * e + 3.0 / 8) * e + 0.5;
#else
  Pack<double> y;
  for (int i = 0; i < lanes<double>; ++i) y[i] = 1 / __builtin_sqrt(a[i]);
  return y;
#endif
#if defined(__x86_64__)
  return y + (y * e) * series;
#endif
}
[[gnu::always_inline]] inline Pack<float> rsqrt(Pack<float> a) {
#if defined(__x86_64__)
#if defined(__AVX512F__)
  const Pack<float> y = _mm512_maskz_rsqrt14_ps(0xFFFF, a);
#elif defined(__AVX2__)
  const Pack<float> y = _mm256_rsqrt_ps(a);
#else
  const Pack<float> y = _mm_rsqrt_ps(a);
#endif
  const Pack<float> e = 1.0F - a * y * y;
  return y + (y * e) * (3.0F / 8 * e + 0.5F);
#else
  Pack<float> y;
  for (int i = 0; i < lanes<float>; ++i) y[i] = 1 / __builtin_sqrtf(a[i]);
  return y;
#endif
}

}  // namespace mss::MSS_ISA
