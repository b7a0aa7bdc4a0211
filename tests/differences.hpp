#pragma once

#include <Eigen/Core>

#include "core/system/system.hpp"

namespace mss::testing {

/// -df/dx, or -df/dv, of all unknowns by central differences, column by column.
inline Eigen::MatrixXd force_differences(System<double>& system, State<double>& state, bool of_positions,
                                         double cell_size) {
  const std::vector<FreeDof> unknowns = unknowns_of(system);
  const auto size = Eigen::Index(unknowns.size());
  Eigen::MatrixXd matrix(size, size);
  Field<double> plus(system.size()), minus(system.size());
  const double step = of_positions ? 1e-5 * cell_size : 1e-3;
  for (Eigen::Index column = 0; column < size; ++column) {
    const auto [site, axis] = unknowns[std::size_t(column)];
    double& coordinate = (of_positions ? state.x : state.v).axis(axis)[site];
    const double before = coordinate;
    coordinate = before + step;
    system.force(0, state.x, state.v, plus);
    coordinate = before - step;
    system.force(0, state.x, state.v, minus);
    coordinate = before;
    for (Eigen::Index row = 0; row < size; ++row) {
      const auto [s, a] = unknowns[std::size_t(row)];
      matrix(row, column) = (minus.axis(a)[s] - plus.axis(a)[s]) / (2 * step);
    }
  }
  return matrix;
}

/// Largest difference over the largest number of b.
inline double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

}  // namespace mss::testing
