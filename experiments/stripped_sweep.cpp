#include "experiments/stripped_sweep.hpp"

#include <string_view>
#include <type_traits>

namespace mss {

#if defined(__x86_64__)
using SweepFloat = void (*)(SweepPlane<float>&);
using SweepDouble = void (*)(SweepPlane<double>&);
SweepFloat stripped_v3_float(Stripped of);
SweepDouble stripped_v3_double(Stripped of);
SweepFloat stripped_v4_float(Stripped of);
SweepDouble stripped_v4_double(Stripped of);
#endif

namespace {

template <class Real>
auto choose(void (*single)(SweepPlane<float>&), void (*dbl)(SweepPlane<double>&)) {
  if constexpr (std::is_same_v<Real, float>)
    return single;
  else
    return dbl;
}

}  // namespace

template <class Real>
std::optional<SweepKernel<Real>> stripped_kernel(Stripped of) {
  SweepKernel<Real> kernel = sweep_kernels<Real>().back();
  const std::string_view name = kernel.name;
#if defined(__x86_64__)
  if (name == "x86-64-v4") {
    kernel.plain.damped = choose<Real>(stripped_v4_float(of), stripped_v4_double(of));
    kernel.plain.undamped = kernel.plain.damped;
    return kernel;
  }
  if (name == "x86-64-v3") {
    kernel.plain.damped = choose<Real>(stripped_v3_float(of), stripped_v3_double(of));
    kernel.plain.undamped = kernel.plain.damped;
    return kernel;
  }
#endif
  return {};
}

template std::optional<SweepKernel<float>> stripped_kernel(Stripped);
template std::optional<SweepKernel<double>> stripped_kernel(Stripped);

}  // namespace mss
