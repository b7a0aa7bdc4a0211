#pragma once

#include <Eigen/Core>
#include <cmath>

#include "core/system/system.hpp"

namespace mss {

/// The unknowns of a field as one vector, in the order given.
inline void gather(const std::vector<FreeDof>& unknowns, const Field<double>& field,
                   Eigen::VectorXd& vector) {
  vector.resize(Eigen::Index(unknowns.size()));
  double* out = vector.data();
  for (const auto [site, axis] : unknowns) *out++ = field.axis(axis)[site];
}

/// The reverse; prescribed coordinates become 0.
inline void scatter(const std::vector<FreeDof>& unknowns, const Eigen::VectorXd& vector,
                    Field<double>& field) {
  field.array() = 0;
  const double* in = vector.data();
  for (const auto [site, axis] : unknowns) field.axis(axis)[site] = *in++;
}

/// 1 at unknowns, 0 elsewhere.
inline Field<double> mask_of_unknowns(System<double>& system) {
  Field<double> mask(system.size());
  for (const auto [site, axis] : tangents_of(system).unknowns()) mask.axis(axis)[site] = 1;
  return mask;
}

/// Roots of the masses that the unknowns have.
inline Eigen::VectorXd root_masses(System<double>& system) {
  const std::vector<FreeDof>& unknowns = tangents_of(system).unknowns();
  Eigen::VectorXd roots(Eigen::Index(unknowns.size()));
  double* out = roots.data();
  for (const auto [site, axis] : unknowns) *out++ = std::sqrt(system.mass(site));
  return roots;
}

}  // namespace mss
