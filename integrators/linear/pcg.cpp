// Block-Jacobi preconditioned conjugate gradients with the assembled sparse matrix.
#include "integrators/linear/conjugate_gradients.hpp"
#include "integrators/linear/unknowns.hpp"

namespace mss {

namespace {

class Pcg final : public ConjugateGradients {
 public:
  using ConjugateGradients::ConjugateGradients;

 protected:
  void prepare_product(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                       const TangentCoefficients& sum, Work&) override {
    if (!tangents_) matrix_ = tangents_of(system).pattern();
    tangents_ = &tangents_of(system);
    tangents_->values(t, x, v, sum, matrix_);
  }
  void product(const Field<double>& p, Field<double>& out) override {
    gather(tangents_->unknowns(), p, direction_);
    image_.noalias() = matrix_ * direction_;
    scatter(tangents_->unknowns(), image_, out);
  }

 private:
  Tangents<double>* tangents_ = nullptr;
  SparseMatrix matrix_;
  Eigen::VectorXd direction_, image_;
};

}  // namespace

LinearSolverInfo pcg() {
  return {.name = "pcg",
          .summary = "conjugate gradients, block-Jacobi, with the assembled sparse matrix",
          .make = [](double tolerance) { return std::make_unique<Pcg>(tolerance); }};
}

}  // namespace mss
