#include "experiments/stripped_sweep.hpp"

#include <string_view>
#include <type_traits>

namespace mss {

#if defined(__x86_64__)
Sweep<float> stripped_v3_float(Stripped of);
Sweep<double> stripped_v3_double(Stripped of);
Sweep<float> stripped_v4_float(Stripped of);
Sweep<double> stripped_v4_double(Stripped of);
#endif

namespace {

template <class Real>
Sweep<Real> choose(Sweep<float> single, Sweep<double> dbl) {
  if constexpr (std::is_same_v<Real, float>)
    return single;
  else
    return dbl;
}

template <class Real>
SweepKernel<Real> with(SweepKernel<Real> kernel, Sweep<Real> sweep) {
  kernel.plain.damped = kernel.plain.undamped = {sweep, sweep, sweep, sweep, sweep};
  return kernel;
}

}  // namespace

template <class Real>
std::optional<SweepKernel<Real>> stripped_kernel(Stripped of) {
  const SweepKernel<Real> kernel = sweep_kernels<Real>().back();
  const std::string_view name = kernel.name;
#if defined(__x86_64__)
  if (name == "x86-64-v4") {
    return with(kernel, choose<Real>(stripped_v4_float(of), stripped_v4_double(of)));
  }
  if (name == "x86-64-v3") {
    return with(kernel, choose<Real>(stripped_v3_float(of), stripped_v3_double(of)));
  }
#endif
  return {};
}

template std::optional<SweepKernel<float>> stripped_kernel(Stripped);
template std::optional<SweepKernel<double>> stripped_kernel(Stripped);

}  // namespace mss
