// Conjugate gradients without a matrix, preconditioned by one multigrid V-cycle in single precision on bodies
// of cells twice, four times ... as large. Rounding in the preconditioner costs iterations, not accuracy.
// Briggs, Henson and McCormick, A Multigrid Tutorial; Tatebe, 1993, for its use within conjugate gradients.
#include "integrators/linear/matrix_free.hpp"
#include "integrators/linear/v_cycle.hpp"

namespace mss {

namespace {

class Multigrid final : public MatrixFree {
 public:
  using MatrixFree::MatrixFree;

 protected:
  Status prepare_preconditioner(System<double>& system, double t, const Field<double>& x,
                                const Field<double>& v, const TangentCoefficients& sum, Work&) override {
    return v_cycle_.prepare(system, t, x, v, sum, mask());
  }
  Products precondition(const std::function<void(Range)>& update, const Field<double>& r, Field<double>& z,
                        double enough) override {
    return precondition_whole(update, r, z, enough, [&](double norm) { v_cycle_.apply(r, norm, z); });
  }

 private:
  VCycle v_cycle_;
};

}  // namespace

LinearSolverInfo multigrid() {
  return {.name = "multigrid",
          .summary = "conjugate gradients, one V-cycle on coarser lattices in single precision, no matrix",
          .products_only = true,
          .one_lattice = true,
          .make = [](double tolerance) { return std::make_unique<Multigrid>(tolerance); }};
}

}  // namespace mss
