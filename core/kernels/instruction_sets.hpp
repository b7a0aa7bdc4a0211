#pragma once

#include <vector>

namespace mss {

/// Of the copies of some loops, one per instruction set, those that this processor can run, slowest first:
/// never empty. The arguments return them; where they are compiled for x86-64 levels 3 and 4 these need AVX2
/// and FMA, and AVX-512.
template <class Loops>
std::vector<Loops> runnable_copies(Loops (*baseline)(), [[maybe_unused]] Loops (*v3)(),
                                   [[maybe_unused]] Loops (*v4)()) {
  std::vector<Loops> copies{baseline()};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) copies.push_back(v3());
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512cd"))
    copies.push_back(v4());
#endif
  return copies;
}

}  // namespace mss
