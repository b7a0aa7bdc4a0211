#pragma once

#include <Eigen/Core>
#include <cmath>

#include "core/system.hpp"

namespace mss {

/// The unknowns of a field as one vector, in the order of a tangent's rows.
inline void gather(System<double>& system, const Field<double>& field, Eigen::VectorXd& vector) {
  const auto& unknowns = system.unknowns();
  vector.resize(Eigen::Index(unknowns.size()));
  double* out = vector.data();
  for (const auto [site, axis] : unknowns) *out++ = field.axis(axis)[site];
}

/// The reverse; prescribed coordinates become 0.
inline void scatter(System<double>& system, const Eigen::VectorXd& vector, Field<double>& field) {
  field.array() = 0;
  const double* in = vector.data();
  for (const auto [site, axis] : system.unknowns()) field.axis(axis)[site] = *in++;
}

/// Roots of the masses that the unknowns have.
inline Eigen::VectorXd root_masses(System<double>& system) {
  Eigen::VectorXd roots(Eigen::Index(system.unknowns().size()));
  double* out = roots.data();
  for (const auto [site, axis] : system.unknowns()) *out++ = std::sqrt(system.mass(site));
  return roots;
}

}  // namespace mss
