// What two coefficients a pair make of H g, against the BFGS formula with whole matrices.
#include "integrators/nonlinear/curvature_pairs.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>
#include <vector>

namespace mss {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A quadratic function with gradient g = A x, a first approximation B of A^-1, and some steps.
struct QuadraticSteps {
  static constexpr int n = 6;
  MatrixXd a, b;
  VectorXd x;
  std::vector<VectorXd> steps;

  explicit QuadraticSteps(int count) : a(n, n), b(n, n), x(n), steps(std::size_t(count), VectorXd(n)) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto fill = [&](auto& values) {
      for (double& value : values.reshaped()) value = uniform(random);
    };
    for (MatrixXd* matrix : {&a, &b}) {
      fill(*matrix);
      *matrix = (*matrix * matrix->transpose() + MatrixXd::Identity(n, n)).eval();
    }
    fill(x);
    for (VectorXd& step : steps) fill(step);
  }
};

/// The pairs of the last steps, as the solver gathers them: by products with gradients, of which z = B g is
/// kept; and beside them the vectors that they stand for.
struct GatheredPairs {
  CurvaturePairs pairs;
  std::vector<VectorXd> s, u;  ///< of the pairs that are kept
  VectorXd gradient;
  PairProducts sg = PairProducts::Zero(), ug = PairProducts::Zero();

  GatheredPairs(const QuadraticSteps& q, int kept) {
    pairs.kept = kept;
    VectorXd x = q.x;
    gradient = q.a * x;
    for (const VectorXd& step : q.steps) {
      x += step;
      const VectorXd before = std::exchange(gradient, q.a * x), y = gradient - before;
      s.push_back(step);
      u.push_back(q.b * y);
      PairProducts sy = PairProducts::Zero(), uy = PairProducts::Zero();
      for (std::size_t i = 0; i < s.size(); ++i) {
        sy[Eigen::Index(i)] = s[i].dot(y);
        uy[Eigen::Index(i)] = u[i].dot(y);
      }
      const auto newest = std::size_t(pairs.count);
      for (Field<double>* field : {&pairs.s[newest], &pairs.u[newest]}) *field = Field<double>(1);
      pairs.s[newest].set(0, Vec3(step[0], 0, 0));
      pairs.u[newest].set(0, Vec3(u.back()[0], 0, 0));
      pairs.push(sy, uy);
      if (s.size() > std::size_t(kept)) {
        s.erase(s.begin());
        u.erase(u.begin());
      }
    }
    for (std::size_t i = 0; i < s.size(); ++i) {
      sg[Eigen::Index(i)] = s[i].dot(gradient);
      ug[Eigen::Index(i)] = u[i].dot(gradient);
    }
  }

  VectorXd sum(const QuadraticSteps& q, const PairProducts& of_s, const PairProducts& of_u) const {
    VectorXd all = q.b * gradient;
    for (std::size_t i = 0; i < s.size(); ++i)
      all += of_s[Eigen::Index(i)] * s[i] + of_u[Eigen::Index(i)] * u[i];
    return all;
  }
};

TEST(CurvaturePairs, GiveTheBfgsUpdate) {
  for (const int steps : {0, 1, 2, 3, 4}) {
    const QuadraticSteps q(steps);
    const GatheredPairs gathered(q, most_pairs);
    ASSERT_EQ(gathered.pairs.count, std::min(steps, most_pairs));
    MatrixXd h = q.b;
    for (const VectorXd& s : gathered.s) {
      const VectorXd y = q.a * s;
      const MatrixXd v = MatrixXd::Identity(q.n, q.n) - y * s.transpose() / y.dot(s);
      h = (v.transpose() * h * v + s * s.transpose() / y.dot(s)).eval();
    }
    PairProducts of_s, of_u;
    gathered.pairs.expand(gathered.sg, gathered.ug, of_s, of_u);
    const VectorXd expected = h * gathered.gradient;
    EXPECT_LT((gathered.sum(q, of_s, of_u) - expected).norm(), 1e-11 * expected.norm()) << steps;
  }
}

TEST(CurvaturePairs, KeepTheNewest) {
  const QuadraticSteps q(5);
  for (const int kept : {1, most_pairs}) {
    const GatheredPairs gathered(q, kept);
    ASSERT_EQ(gathered.pairs.count, kept);
    for (int i = 0; i < kept; ++i) {
      EXPECT_EQ(gathered.pairs.s[std::size_t(i)].at(0)[0], gathered.s[std::size_t(i)][0]);
      EXPECT_EQ(gathered.pairs.u[std::size_t(i)].at(0)[0], gathered.u[std::size_t(i)][0]);
    }
  }
}

// Conjugate to the last step: p.A s = 0.
TEST(CurvaturePairs, GiveConjugateDirections) {
  for (const int steps : {1, 3}) {
    const QuadraticSteps q(steps);
    const GatheredPairs gathered(q, 1);
    PairProducts of_s, of_u;
    gathered.pairs.conjugate(gathered.ug, of_s, of_u);
    const VectorXd p = gathered.sum(q, of_s, of_u), y = q.a * gathered.s.back();
    EXPECT_NEAR(p.dot(y), 0, 1e-12 * p.norm() * y.norm());
    EXPECT_GT((p - q.b * gathered.gradient).norm(), 1e-3 * p.norm());
  }
}

}  // namespace
}  // namespace mss
