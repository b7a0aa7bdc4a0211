// Predicted steps against dense linear algebra: the limit of a whole body, not of a test equation.
#include "integrators/analysis/stable_step.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "core/springs/spring_system.hpp"
#include "integrators/analysis/modes.hpp"
#include "tests/dense_eigenvalues.hpp"

namespace mss {
namespace {

using Eigen::MatrixXd;

/// A free cube, its springs damped by a ratio of critical.
struct Cube {
  explicit Cube(int n, double ratio) : body(config(n, ratio)), system(body, {}, {.threads = 1}) {}
  static BodyConfig config(int n, double ratio) {
    BodyConfig config{.voxels = VoxelGrid::box(n, n, n), .cell_size = 1.0 / n};
    if (ratio > 0) config.damping = {.law = Damping::Law::ratio, .zeta = ratio};
    config.fill({.young = 1e4, .poisson = 0.3}, 0.5);
    return config;
  }
  double predicted(const std::string& method) {
    Work work;
    const PredictedStep step =
        predicted_step(find_integrator(method), system, system.undeformed_state(), work);
    EXPECT_EQ(step.status, Status::ok);
    return step.dt;
  }
  /// M^-1/2 A M^-1/2 of a sum A.
  MatrixXd matrix(const TangentCoefficients& sum) {
    const State<double> rest = system.undeformed_state();
    SparseMatrix sparse = system.tangents()->pattern();
    system.tangents()->values(0, rest.x, rest.v, sum, sparse);
    MatrixXd a(sparse);
    for (Eigen::Index i = 0; i < a.rows(); ++i)
      for (Eigen::Index j = 0; j < a.cols(); ++j)
        a(i, j) /= std::sqrt(system.mass(system.tangents()->unknowns()[std::size_t(i)].site) *
                             system.mass(system.tangents()->unknowns()[std::size_t(j)].site));
    return a;
  }
  MatrixXd stiffness() { return matrix({.stiffness = 1, .kind = Tangent::elastic}); }
  MatrixXd damping() { return matrix({.damping = 1, .kind = Tangent::elastic}); }

  Body body;
  SpringSystem<double> system;
};

/// Where `largest`, which grows with the step, reaches `bound`.
template <class Function>
double bisect(double low, double high, double bound, Function&& largest) {
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (largest(middle) > bound ? high : low) = middle;
  }
  return low;
}

double largest_eigenvalue(const MatrixXd& a) { return testing::symmetric_eigenvalues(a).maxCoeff(); }

TEST(PredictedStep, IsThatOfTheFastestModeWithoutDamping) {
  Cube cube(4, 0);
  Work work;
  const double omega = fastest_mode(cube.system, cube.system.undeformed_state(), work).modes[0].omega;
  EXPECT_NEAR(cube.predicted("verlet") * omega, 2, 1e-6);
  EXPECT_NEAR(cube.predicted("rk4") * omega, std::sqrt(8), 1e-6);
  EXPECT_EQ(cube.predicted("explicit_euler"), 0);
  EXPECT_TRUE(std::isinf(cube.predicted("backward_euler")));
}

// Springs damped by a ratio of their own critical damping: C is no multiple of K, and shares no modes with
// it.
TEST(PredictedStep, IsWhereTheBodysOwnMatricesSay) {
  for (const double ratio : {0.05, 0.5, 1.0}) {
    Cube cube(2, ratio);
    const MatrixXd k = cube.stiffness(), c = cube.damping();
    EXPECT_GT((k * c - c * k).norm(), 1e-6 * k.norm() * c.norm());
    const double longest = 2 / std::sqrt(largest_eigenvalue(k));
    const double lagged =
        bisect(0, longest, 4, [&](double dt) { return largest_eigenvalue(dt * dt * k + 2 * dt * c); });
    EXPECT_NEAR(cube.predicted("semi_implicit_euler") / lagged, 1, 1e-5) << ratio;
    EXPECT_NEAR(cube.predicted("verlet") / lagged, 1, 1e-5) << ratio;
    const double in_time =
        bisect(0, longest, 4, [&](double dt) { return largest_eigenvalue(dt * dt * k + 4 * dt * c); });
    EXPECT_NEAR(cube.predicted("damped_verlet") / in_time, 1, 1e-5) << ratio;
  }
}

/// Those of the first-order form of the whole body, without rigid motions.
Eigen::VectorXcd exponents_of(const MatrixXd& k, const MatrixXd& c) {
  const Eigen::Index n = k.rows();
  MatrixXd first_order = MatrixXd::Zero(2 * n, 2 * n);
  first_order.topRightCorner(n, n).setIdentity();
  first_order.bottomLeftCorner(n, n) = -k;
  first_order.bottomRightCorner(n, n) = -c;
  Eigen::VectorXcd all = first_order.eigenvalues();
  const double rigid = 1e-6 * std::sqrt(k.norm());
  const auto end = std::remove_if(all.begin(), all.end(), [&](const auto& z) { return std::abs(z) < rigid; });
  return all.head(end - all.begin()).eval();
}

/// Largest |R(z)| of a one-step method.
template <class Amplification>
double growth(const Eigen::VectorXcd& exponents, double dt, Amplification&& of) {
  double most = 0;
  for (const std::complex<double>& exponent : exponents) most = std::max(most, std::abs(of(exponent * dt)));
  return most;
}

void expect_dense_limits(int n, double ratio) {
  Cube cube(n, ratio);
  const MatrixXd k = cube.stiffness(), c = cube.damping();
  const double longest = 4 / std::sqrt(largest_eigenvalue(k));
  const Eigen::VectorXcd exponents = exponents_of(k, c);
  const auto taylor = [](std::complex<double> z) {
    return 1.0 + z * (1.0 + z * (0.5 + z * (1.0 / 6 + z / 24.0)));
  };
  const auto euler = [](std::complex<double> z) { return 1.0 + z; };
  const double rk4 = bisect(0, longest, 1 + 1e-12, [&](double dt) { return growth(exponents, dt, taylor); });
  EXPECT_NEAR(cube.predicted("rk4") / rk4, 1, 2e-4) << n << " " << ratio;
  const double first = bisect(0, longest, 1 + 1e-12, [&](double dt) { return growth(exponents, dt, euler); });
  EXPECT_NEAR(cube.predicted("explicit_euler") / first, 1, 2e-4) << n << " " << ratio;
}

TEST(PredictedStep, IsThatOfComplexEigenvalues) {
  for (const double ratio : {0.05, 0.5, 1.0}) expect_dense_limits(2, ratio);  // where all are computed
  for (const double ratio : {0.05, 0.5}) expect_dense_limits(3, ratio);       // by Arnoldi
}

TEST(PredictedStep, IsNeverBelowTheGuaranteedStep) {
  for (const double ratio : {0.0, 0.2, 1.0})
    for (const char* method : {"verlet", "velocity_verlet", "damped_verlet", "rk4"}) {
      Cube cube(3, ratio);
      EXPECT_GT(cube.predicted(method), stable_step(find_integrator(method), cube.system.spectral_bound()));
    }
}

TEST(PolynomialLimit, IsThatOfKnownMethods) {
  const std::vector<double> rk4{1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24}, heun{1, 1, 0.5}, euler{1, 1};
  EXPECT_NEAR(polynomial_limit(rk4, 2, 0), std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(polynomial_limit(rk4, 0, 1), 2.785293563405, 1e-9);
  EXPECT_EQ(polynomial_limit(heun, 2, 0), 0);
  EXPECT_NEAR(polynomial_limit(heun, 0, 4), 0.5, 1e-9);
  EXPECT_EQ(polynomial_limit(euler, 1, 0), 0);
  EXPECT_NEAR(polynomial_limit(euler, 1, 0.5), 0.5, 1e-9);  // c / w^2
  EXPECT_EQ(polynomial_limit(rk4, 0, 0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(polynomial_limit(rk4, 1e150, 1e303), 0);  // found by the fuzzer: such steps are no numbers
}

}  // namespace
}  // namespace mss
