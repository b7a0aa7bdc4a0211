#pragma once

#include <cmath>
#include <complex>

#include "core/springs/discrete_gradient.hpp"

namespace mss::testing {

/// Of linear forces: that at the midpoint is one.
class LinearDiscreteGradient final : public DiscreteGradient<double> {
 public:
  void correct(const Field<double>&, const Field<double>&, Field<double>&) override {}
};

/// One particle on a damped spring along x: x'' = -w^2 x - c x'. Its solution is known, and it is a System of
/// its own: methods are tested on any System, not on the sweep.
class Oscillator final : public System<double> {
 public:
  Oscillator(double omega, double damping) : omega_(omega), damping_(damping) {}

  std::ptrdiff_t size() const override { return 1; }
  const std::vector<std::ptrdiff_t>& particles() const override { return particles_; }
  double mass(std::ptrdiff_t) const override { return mass_; }
  void force(double, const Field<double>& x, const Field<double>& v, Field<double>& f) override {
    for (int a = 0; a < 3; ++a)
      f.axis(a)[0] = -mass_ * (omega_ * omega_ * x.axis(a)[0] + damping_ * v.axis(a)[0]);
  }

  Tangents<double>* tangents() override { return &tangents_; }
  DiscreteGradient<double>* discrete_gradient() override { return &discrete_gradient_; }

  State<double> start(double x, double v) const {
    State<double> state{0, Field<double>(1), Field<double>(1)};
    state.x.axis(0)[0] = x;
    state.v.axis(0)[0] = v;
    return state;
  }

  /// Position at time t of the solution through (x, v) at 0; underdamped.
  double exact(double x, double v, double t) const {
    const double decay = damping_ / 2, frequency = std::sqrt(omega_ * omega_ - decay * decay);
    return std::exp(-decay * t) *
           (x * std::cos(frequency * t) + (v + decay * x) / frequency * std::sin(frequency * t));
  }

 private:
  double along(const TangentCoefficients& sum) const {
    return mass_ * (sum.mass + sum.damping * damping_ + sum.stiffness * omega_ * omega_);
  }

  class OscillatorTangents final : public Tangents<double> {
   public:
    explicit OscillatorTangents(const Oscillator& system) : system_(system) {}
    const std::vector<FreeDof>& unknowns() override { return unknowns_; }
    SparseMatrix pattern() override {
      SparseMatrix matrix(3, 3);
      matrix.setIdentity();
      return matrix;
    }
    void values(double, const Field<double>&, const Field<double>&, const TangentCoefficients& sum,
                SparseMatrix& matrix) override {
      for (int i = 0; i < 3; ++i) matrix.valuePtr()[i] = system_.along(sum);
    }
    void product(double, const Field<double>&, const Field<double>&, const TangentCoefficients& sum,
                 const Field<double>& p, Field<double>& out) override {
      for (int a = 0; a < 3; ++a) out.axis(a)[0] = system_.along(sum) * p.axis(a)[0];
    }
    void diagonal(double, const Field<double>&, const Field<double>&, const TangentCoefficients& sum,
                  std::vector<Eigen::Matrix3d>& blocks) override {
      blocks.assign(1, system_.along(sum) * Eigen::Matrix3d::Identity());
    }

   private:
    const Oscillator& system_;
    std::vector<FreeDof> unknowns_{{0, 0}, {0, 1}, {0, 2}};
  };

  double omega_;
  double damping_;
  double mass_ = 0.7;
  std::vector<std::ptrdiff_t> particles_{0};
  OscillatorTangents tangents_{*this};
  LinearDiscreteGradient discrete_gradient_;
};

}  // namespace mss::testing
