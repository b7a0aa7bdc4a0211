#pragma once

#include "integrators/linear/conjugate_gradients.hpp"

namespace mss {

/// Conjugate gradients without a matrix: a product costs about one force evaluation, through the same sweep.
class MatrixFree : public ConjugateGradients {
 public:
  using ConjugateGradients::ConjugateGradients;

 protected:
  void prepare_product(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                       const TangentCoefficients& sum, Work&) override {
    tangents_ = &tangents_of(system);
    t_ = t;
    x_ = &x;
    v_ = &v;
    sum_ = sum;
  }
  void product(const Field<double>& p, Field<double>& out) override {
    tangents_->product(t_, *x_, *v_, sum_, p, out);
  }

 private:
  Tangents<double>* tangents_ = nullptr;
  double t_ = 0;
  const Field<double>* x_ = nullptr;
  const Field<double>* v_ = nullptr;
  TangentCoefficients sum_;
};

}  // namespace mss
