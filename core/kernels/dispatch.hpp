#pragma once

// Loops that are compiled for several instruction sets, and the choice among the copies at run time, so that
// the binary needs no -march=native. A family of them is a NAME_isa.cpp, which cmake/MssKernelCopies.cmake
// compiles once per instruction set (and precision) with these defined:
//   MSS_ISA              the namespace of the copy, such as isa_v3
//   MSS_INSTRUCTION_SET  its InstructionSet, such as v3
//   MSS_ISA_NAME         how users know it, such as "x86-64-v3"
//   MSS_REAL             float or double

#include <vector>

namespace mss {

/// Slowest first. On other processors than x86-64 all are the first.
enum class InstructionSet { baseline, v3, v4 };

/// The loops of a NAME_isa.cpp for one instruction set. `Kernel` is a table of functions.
template <class Kernel, InstructionSet set>
Kernel kernel_copy();

/// To be written once for each table of functions that there are copies of.
#define MSS_KERNEL_COPIES(...)                                      \
  template <>                                                       \
  __VA_ARGS__ kernel_copy<__VA_ARGS__, InstructionSet::baseline>(); \
  template <>                                                       \
  __VA_ARGS__ kernel_copy<__VA_ARGS__, InstructionSet::v3>();       \
  template <>                                                       \
  __VA_ARGS__ kernel_copy<__VA_ARGS__, InstructionSet::v4>()

/// Whether this processor can run what is compiled for an instruction set: levels 3 and 4 of x86-64 need AVX2
/// and FMA, and AVX-512.
inline bool can_run([[maybe_unused]] InstructionSet set) {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (set == InstructionSet::v3) return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (set == InstructionSet::v4)
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512cd");
#endif
  return set == InstructionSet::baseline;
}

/// The copies that this processor can run, slowest first: never empty.
template <class Kernel>
const std::vector<Kernel>& runnable_copies() {
  static const std::vector<Kernel> copies = [] {
    std::vector<Kernel> runnable{kernel_copy<Kernel, InstructionSet::baseline>()};
    if (can_run(InstructionSet::v3)) runnable.push_back(kernel_copy<Kernel, InstructionSet::v3>());
    if (can_run(InstructionSet::v4)) runnable.push_back(kernel_copy<Kernel, InstructionSet::v4>());
    return runnable;
  }();
  return copies;
}

template <class Kernel>
const Kernel& fastest_copy() {
  return runnable_copies<Kernel>().back();
}

}  // namespace mss
