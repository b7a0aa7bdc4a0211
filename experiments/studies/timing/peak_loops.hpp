#pragma once

// What a processor can do at most: fused multiply-adds that wait for nothing but themselves, and a stream
// through memory. Included once per instruction set, see core/kernels/simd.hpp.

#include "core/kernels/simd.hpp"
#include "experiments/studies/timing/peaks.hpp"

namespace mss::MSS_ISA {

/// More chains than there are operations in flight (latency 4 or 5, two a cycle), and few enough for sixteen
/// registers.
inline constexpr int chains = 12;

/// x = x f + g on every chain, `rounds` times; stays near 1.
template <class Real>
double multiply_add(long rounds) {
  const Pack<Real> zero{}, factor = zero + Real(0.5), addend = zero + Real(0.5);
  Pack<Real> x[chains];
  for (int i = 0; i < chains; ++i) x[i] = zero + Real(1 + 0.01 * i);
  for (long round = 0; round < rounds; ++round)
#pragma GCC unroll 12
    for (Pack<Real>& chain : x) chain = chain * factor + addend;
  Pack<Real> sum{};
  for (const Pack<Real>& chain : x) sum = sum + chain;
  return double(sum[0]);
}

inline void triad(double* a, const double* b, const double* c, double s, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) a[i] = b[i] + s * c[i];
}

inline studies::timing::PeakLoops make_peak_loops(const char* name) {
  return {name,
          {multiply_add<double>, 2.0 * chains * lanes<double>},
          {multiply_add<float>, 2.0 * chains * lanes<float>},
          triad};
}

}  // namespace mss::MSS_ISA
