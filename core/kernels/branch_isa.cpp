// Compiled once per instruction set and precision, see core/kernels/dispatch.hpp.
#include <cmath>

#include "core/kernels/branch_kernel.hpp"
#include "core/kernels/independent_loop.hpp"

namespace mss {

namespace MSS_ISA {

namespace {

/// A row whose pointers no store can change, so that loops over it become vectors.
template <class Real>
struct Loop {
  explicit Loop(const BranchRow<Real>& row)
      : stiffness(row.stiffness),
        ax(row.a[0]),
        ay(row.a[1]),
        az(row.a[2]),
        bx(row.b[0]),
        by(row.b[1]),
        bz(row.b[2]),
        decay(row.decay),
        gain(row.gain) {}

  Real x(std::ptrdiff_t i) const { return bx[i] - ax[i]; }
  Real y(std::ptrdiff_t i) const { return by[i] - ay[i]; }
  Real z(std::ptrdiff_t i) const { return bz[i] - az[i]; }
  /// Never 0, for sites that coincide where there is no branch: without a comparison loops become vectors.
  Real length(std::ptrdiff_t i) const {
    constexpr Real smallest = sizeof(Real) == 8 ? Real(1e-300) : Real(1e-30);
    return std::sqrt(x(i) * x(i) + y(i) * y(i) + z(i) * z(i) + smallest);
  }

  const Real* stiffness;
  const Real *ax, *ay, *az, *bx, *by, *bz;
  Real decay, gain;
};

template <class Real>
void pull(const BranchRow<Real>& row, Real* force, std::ptrdiff_t stride) {
  const Loop<Real> loop(row);
  const Real *before = row.tension, *from = row.length;
  Real *fx = force, *fy = force + stride, *fz = force + 2 * stride;
  const std::ptrdiff_t count = row.count;
  MSS_INDEPENDENT
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Real length = loop.length(i);
    const Real over_length =
        (loop.decay * before[i] + loop.gain * loop.stiffness[i] * (length - from[i])) / length;
    fx[i] = over_length * loop.x(i);
    fy[i] = over_length * loop.y(i);
    fz[i] = over_length * loop.z(i);
  }
}

template <class Real>
void advance(const BranchRow<Real>& row, Real* before, Real* stretched) {
  const Loop<Real> loop(row);
  Real *tension = row.tension, *length = row.length;
  const std::ptrdiff_t count = row.count;
  MSS_INDEPENDENT
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Real now = loop.length(i);
    before[i] = tension[i];
    stretched[i] = loop.stiffness[i] * (now - length[i]);
    tension[i] = loop.decay * before[i] + loop.gain * stretched[i];
    length[i] = now;
  }
}

template <class Real>
void add(std::ptrdiff_t count, Real sign, const Real* force, Real* target) {
  MSS_INDEPENDENT
  for (std::ptrdiff_t i = 0; i < count; ++i) target[i] += sign * force[i];
}

}  // namespace

}  // namespace MSS_ISA

template <>
BranchKernel<MSS_REAL> kernel_copy<BranchKernel<MSS_REAL>, InstructionSet::MSS_INSTRUCTION_SET>() {
  return {MSS_ISA_NAME, MSS_ISA::pull<MSS_REAL>, MSS_ISA::advance<MSS_REAL>, MSS_ISA::add<MSS_REAL>};
}

}  // namespace mss
