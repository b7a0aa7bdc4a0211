#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/measures/measures.hpp"
#include "tests/differences.hpp"
#include "tests/random_bodies.hpp"

namespace mss::testing {

/// A tangent as it is stored.
inline Eigen::MatrixXd tangent_matrix(SolidSystem<double>& system, const State<double>& state,
                                      const TangentCoefficients& sum) {
  SparseMatrix matrix = system.tangents()->pattern();
  system.tangents()->values(0, state.x, state.v, sum, matrix);
  return Eigen::MatrixXd(matrix);
}

/// Expects tangents that are differences of the forces, and products and a diagonal that are the matrix's.
inline void compare_tangents_with_forces(SolidSystem<double>& system, State<double>& state) {
  for (const bool of_positions : {true, false}) {
    const Eigen::MatrixXd expected =
        force_differences(system, state, of_positions, 1e-3 * system.cell_size());
    const TangentCoefficients sum =
        of_positions ? TangentCoefficients{.stiffness = 1} : TangentCoefficients{.damping = 1};
    EXPECT_LT(relative_difference(tangent_matrix(system, state, sum), expected), 1e-4);
  }
  const TangentCoefficients sum{.mass = 2, .damping = 0.3, .stiffness = 5, .kind = Tangent::elastic};
  const Eigen::MatrixXd matrix = tangent_matrix(system, state, sum);
  EXPECT_LT((matrix - matrix.transpose()).norm(), 1e-12 * matrix.norm());
  State<double> direction = system.rest_state();
  randomise(system, direction, 1, 1, 9);
  Field<double> out(system.size());
  system.tangents()->product(0, state.x, state.v, sum, direction.v, out);
  Eigen::VectorXd p(matrix.rows()), product(matrix.rows());
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const auto [site, axis] = system.tangents()->unknowns()[std::size_t(i)];
    p[i] = direction.v.axis(axis)[site];
    product[i] = out.axis(axis)[site];
  }
  EXPECT_LT((product - matrix * p).norm(), 1e-12 * product.norm());
  std::vector<Eigen::Matrix3d> blocks;
  system.tangents()->diagonal(0, state.x, state.v, sum, blocks);
  for (Eigen::Index b = 0; b < Eigen::Index(blocks.size()); ++b)
    EXPECT_LT((blocks[std::size_t(b)] - matrix.block<3, 3>(3 * b, 3 * b)).norm(), 1e-12 * matrix.norm());
}

/// Expects the forces to be the negative gradient of the total energy.
inline void compare_forces_with_energy(SolidSystem<double>& system, State<double>& state) {
  Field<double> f(system.size());
  system.force(0, state.x, state.v, f);
  for (const auto [site, axis] : system.tangents()->unknowns()) {
    double& x = state.x.axis(axis)[site];
    const double before = x, step = 1e-6 * system.cell_size();
    x = before + step;
    const double above = measure(system, state).total();
    x = before - step;
    const double below = measure(system, state).total();
    x = before;
    EXPECT_NEAR((below - above) / (2 * step), f.axis(axis)[site], 1e-5 * f.array().abs().maxCoeff());
  }
}

}  // namespace mss::testing
