#pragma once

#include "core/body/body.hpp"
#include "core/system/system.hpp"

namespace mss {

/// The forces of a whole step from x0 to x1 whose work is exactly what the elastic energy E loses,
///   f . (x1 - x0) = E(x0) - E(x1),
/// as a change of the forces at the midpoint, which System::force() has: both tend to the same as the step
/// shrinks. Gonzalez, J. Nonlinear Sci. 6 (1996) 449; Hairer, Lubich and Wanner, Geometric Numerical
/// Integration, V.5.
template <class Real>
class DiscreteGradient {
 public:
  DiscreteGradient() = default;
  DiscreteGradient(const DiscreteGradient&) = delete;
  DiscreteGradient& operator=(const DiscreteGradient&) = delete;
  virtual ~DiscreteGradient() = default;

  /// Adds to f [N], the forces at (x0 + x1) / 2, shape 3 x sites, what makes them a discrete gradient.
  virtual void correct(const Field<Real>& x0, const Field<Real>& x1, Field<Real>& f) = 0;
};

/// A system's discrete gradient. Throws InputError if it has none.
template <class Real>
DiscreteGradient<Real>& discrete_gradient_of(System<Real>& system);

/// That of a body of springs, with the volume force of eq. 3-7. With d a spring's ends' difference, r = |d|,
/// and a bar for the mean of x0 and x1, the force on its first end is
///   k (1 - L0 / rbar) dbar   instead of   k (1 - L0 / |dbar|) dbar,
/// because the elongation energy k (r - L0)^2 / 2 changes by k (rbar - L0) (r1 - r0), and r1^2 - r0^2 is 2
/// dbar . (d1 - d0). It pulls along dbar, so angular momentum is exact too. LaBudde and Greenspan, Numer.
/// Math. 25 (1976) 323 and 26 (1976) 1; Simo and Tarnow, ZAMP 43 (1992) 757. A cell's volume V is cubic along
/// the step, so that Simpson's rule gives the mean of its gradient exactly (the average vector field of
/// Quispel and McLaren, J. Phys. A 41 (2008) 045206), and the force is
///   -k_vol (Vbar - V_rest) / V_rest (grad V(x0) + 4 grad V(xbar) + grad V(x1)) / 6.
/// The guard against folding stays as it is at the midpoint.
template <class Real>
class SpringDiscreteGradient final : public DiscreteGradient<Real> {
 public:
  /// The body must outlive it.
  explicit SpringDiscreteGradient(const Body& body) : body_(body) {}

  void correct(const Field<Real>& x0, const Field<Real>& x1, Field<Real>& f) override;

 private:
  void correct_springs(const Field<Real>& x0, const Field<Real>& x1, Field<Real>& f) const;
  void correct_volumes(const Field<Real>& x0, const Field<Real>& x1, Field<Real>& f) const;

  const Body& body_;
};

}  // namespace mss
