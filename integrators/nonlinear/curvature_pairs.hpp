#pragma once

#include <Eigen/Core>
#include <array>

#include "core/base/field.hpp"

namespace mss {

inline constexpr int most_pairs = 2;

/// Products of a vector with every step, and with every change of z.
using PairProducts = Eigen::Matrix<double, most_pairs + 1, 1>;

/// The last steps s of a quasi-Newton method and the changes u = B y of z = B g in them, oldest first; y is
/// the change of the gradient g, and B the approximate inverse of the matrix that the method begins with. H
/// g, where H is B as the pairs correct it, is a sum of z, s and u, whose coefficients are found here; y is
/// not stored. L-BFGS's two loops run over coefficients, from products of s and u with the gradients g and g'
/// about a step:
///   s_i.y = s_i.g' - s_i.g,   y_i.B y = u_i.g' - u_i.g.
/// Nocedal and Wright, Numerical Optimization, ch. 7.
struct CurvaturePairs {
  int kept = most_pairs, count = 0;
  /// One place more than pairs: the newest is written before the oldest is given up.
  std::array<Field<double>, most_pairs + 1> s, u;
  Eigen::Matrix<double, most_pairs + 1, most_pairs + 1> sy, uy;  ///< (older, newer); (i, i) too

  /// Takes s[count] and u[count] as a pair, with its products.
  void push(const PairProducts& s_with_y, const PairProducts& u_with_y);
  /// Coefficients of s and u in H g - z by the BFGS formula, from products with g.
  void expand(const PairProducts& sg, const PairProducts& ug, PairProducts& of_s, PairProducts& of_u) const;
  /// The same of the conjugate direction to the last step.
  void conjugate(const PairProducts& ug, PairProducts& of_s, PairProducts& of_u) const;
};

}  // namespace mss
