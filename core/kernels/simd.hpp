#pragma once

// A thin layer over the vector extensions of GCC and Clang: arithmetic is the compiler's, this adds unaligned
// memory access, a lane shift and the reciprocal square root. Included only by the sweep, which is compiled
// once per instruction set; MSS_ISA names the namespace of that copy, so that the linker never mixes two of
// them. For the same reason nothing here may call an inline function of the standard library.

#include <cstddef>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "core/base/kernel_number.hpp"

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
MSS_INLINE Pack<Real> load(const Real* p) {
  return *reinterpret_cast<const typename PackOf<Real>::unaligned*>(p);
}
template <class Real>
MSS_INLINE void store(Real* p, Pack<Real> v) {
  *reinterpret_cast<typename PackOf<Real>::unaligned*>(p) = v;
}

/// (previous[W-1], v[0], ..., v[W-2]): values that belong one lane further on, and the last of the block
/// before.
MSS_INLINE Pack<double> shift_in(Pack<double> previous, Pack<double> v) {
#if defined(__AVX512F__)
  return __builtin_shufflevector(previous, v, 7, 8, 9, 10, 11, 12, 13, 14);
#elif defined(__AVX2__)
  return __builtin_shufflevector(previous, v, 3, 4, 5, 6);
#else
  return __builtin_shufflevector(previous, v, 1, 2);
#endif
}
MSS_INLINE Pack<float> shift_in(Pack<float> previous, Pack<float> v) {
#if defined(__AVX512F__)
  return __builtin_shufflevector(previous, v, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30);
#elif defined(__AVX2__)
  return __builtin_shufflevector(previous, v, 7, 8, 9, 10, 11, 12, 13, 14);
#else
  return __builtin_shufflevector(previous, v, 3, 4, 5, 6);
#endif
}

/// Whether a comparison is true in any lane.
#if defined(__AVX512DQ__)
MSS_INLINE bool any(decltype(Pack<double>{} < Pack<double>{}) mask) {
  return _mm512_movepi64_mask((__m512i)mask) != 0;
}
MSS_INLINE bool any(decltype(Pack<float>{} < Pack<float>{}) mask) {
  return _mm512_movepi32_mask((__m512i)mask) != 0;
}
#elif defined(__AVX2__)
MSS_INLINE bool any(decltype(Pack<double>{} < Pack<double>{}) mask) {
  return _mm256_movemask_pd((__m256d)mask) != 0;
}
MSS_INLINE bool any(decltype(Pack<float>{} < Pack<float>{}) mask) {
  return _mm256_movemask_ps((__m256)mask) != 0;
}
#elif defined(__x86_64__)
MSS_INLINE bool any(decltype(Pack<double>{} < Pack<double>{}) mask) {
  return _mm_movemask_pd((__m128d)mask) != 0;
}
MSS_INLINE bool any(decltype(Pack<float>{} < Pack<float>{}) mask) {
  return _mm_movemask_ps((__m128)mask) != 0;
}
#else
template <class Mask>
MSS_INLINE bool any(Mask mask) {
  for (int i = 0; i < int(sizeof mask / sizeof mask[0]); ++i)
    if (mask[i] != 0) return true;
  return false;
}
#endif

// The reciprocal square root, rsqrt_scale times too large. Of a hardware estimate y = (1 + e) / sqrt(a)
// Newton's step without its factor 1/2, y (3 - a y^2), makes 2 / sqrt(a) (1 - 3/2 e^2), and Halley's without
// 1/8, y (15 - a y^2 (10 - 3 a y^2)), 8 / sqrt(a) (1 + 5/2 e^3). Leaving the factors in saves
// multiplications, and they disappear into the spring's coefficients. Square root and division would cost as
// much as the rest of the spring.
//   double           e        first step           then Newton's      scale
//   baseline, AVX2   3.7e-4   Halley's, 1.3e-10    below rounding     8 * 128
//   AVX-512          6.1e-5   Newton's, 5.6e-9     below rounding     2 * 8
//   float            3.7e-4   Newton's, 2e-7       none               2
// Nothing less will do: a force is the difference of a spring's length and its rest length, so near rest an
// error of 1e-14 is one of 1e-8 in the force at a strain of 1e-6.
#if defined(__x86_64__) && !defined(__AVX512F__)
template <class Real>
inline constexpr Real rsqrt_scale = sizeof(Real) == 8 ? 1024 : 2;
#else
template <class Real>
inline constexpr Real rsqrt_scale = sizeof(Real) == 8 ? 16 : 2;
#endif

#if defined(__x86_64__)
MSS_INLINE Pack<double> rsqrt_estimate(Pack<double> a) {
#if defined(__AVX512F__)
  return _mm512_maskz_rsqrt14_pd(0xFF, a);  // the unmasked form makes GCC 12 warn
#elif defined(__AVX2__)
  return _mm256_cvtps_pd(_mm_rsqrt_ps(_mm256_cvtpd_ps(a)));
#else
  return _mm_cvtps_pd(_mm_rsqrt_ps(_mm_cvtpd_ps(a)));
#endif
}
MSS_INLINE Pack<float> rsqrt_estimate(Pack<float> a) {
#if defined(__AVX512F__)
  return _mm512_maskz_rsqrt14_ps(0xFFFF, a);
#elif defined(__AVX2__)
  return _mm256_rsqrt_ps(a);
#else
  return _mm_rsqrt_ps(a);
#endif
}
MSS_INLINE Pack<double> scaled_rsqrt(Pack<double> a, Pack<double> y) {
  const Pack<double> ay = a * y;
#if defined(__AVX512F__)
  constexpr double last = 12;
  const Pack<double> step = 3.0 - ay * y;
#else
  constexpr double last = 192;
  const Pack<double> ay2_first = ay * y, step = 15.0 - ay2_first * (10.0 - 3.0 * ay2_first);
#endif
  const Pack<double> y2 = y * step,
                     ay2 = ay * step;  // side by side: the chain of dependent operations is what costs
  return y2 * (last - ay2 * y2);
}
MSS_INLINE Pack<float> scaled_rsqrt(Pack<float> a, Pack<float> y) { return y * (3.0F - a * y * y); }
#else
/// Other processors have the exact value instead of an estimate.
template <class PackReal>
MSS_INLINE PackReal rsqrt_estimate(PackReal a) {
  for (int i = 0; i < int(sizeof a / sizeof a[0]); ++i) a[i] = 1 / __builtin_sqrt(a[i]);
  return a;
}
MSS_INLINE Pack<double> scaled_rsqrt(Pack<double>, Pack<double> y) { return rsqrt_scale<double> * y; }
MSS_INLINE Pack<float> scaled_rsqrt(Pack<float>, Pack<float> y) { return rsqrt_scale<float> * y; }
#endif

}  // namespace mss::MSS_ISA
