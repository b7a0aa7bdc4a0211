// The default: the factorisation while bodies are small, multigrid above, where it is many times faster.
#include <fmt/format.h>

#include "core/springs/body_system.hpp"
#include "integrators/linear/linear_solver.hpp"

namespace mss {

LinearSolverInfo cholmod();
LinearSolverInfo multigrid();

namespace {

/// With one right-hand side a matrix, multigrid is faster from a few hundred particles on; with many, from a
/// few thousand.
constexpr std::size_t most_factored = 1000;

class Automatic final : public LinearSolver {
 public:
  explicit Automatic(double tolerance) : tolerance_(tolerance) {}

  Status prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                 const TangentCoefficients& sum, Work& work) override {
    if (!chosen_) {
      const bool large = system.particles().size() > most_factored;
      const BodySystem<double>* cells = system.cells();
      const bool has_cells = cells != nullptr && cells->body().config().is_solid();
      chosen_ = (large && has_cells ? multigrid() : cholmod()).make(tolerance_);
    }
    return chosen_->prepare(system, t, x, v, sum, work);
  }
  Status solve(const Field<double>& rhs, Field<double>& solution, Work& work) override {
    return chosen_->solve(rhs, solution, work);
  }

 private:
  double tolerance_;
  std::unique_ptr<LinearSolver> chosen_;
};

}  // namespace

LinearSolverInfo automatic() {
  return {
      .name = "automatic",
      .summary = fmt::format(
          "the default: cholmod for bodies of up to {} particles, multigrid for larger ones", most_factored),
      .make = [](double tolerance) { return std::make_unique<Automatic>(tolerance); }};
}

}  // namespace mss
