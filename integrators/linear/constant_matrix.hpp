#pragma once

#include <array>
#include <memory>
#include <string>

#include "core/springs/body_system.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// The matrix m M + sum_s w_s (e_i - e_j)(e_i - e_j)^T over a body's springs s between particles i and j, one
/// number per pair of particles: the same for x, y and z, and the same wherever the body is. Every spring has
/// its class's weight, times its stiffness over that of an interior one (SiteKinds::interior_stiffness).
struct ConstantMatrix {
  double mass = 0;                 ///< m
  std::array<double, 3> spring{};  ///< w of interior springs by class: edge, face, body
  double cell_edge = 0;            ///< added to w by every cell, on its twelve edges

  bool operator==(const ConstantMatrix&) const = default;
};

/// A constant matrix that, for any x and v, is at least a M + b C + c K, as far as that is positive and of
/// springs and the volume force: springs pull with k along their direction only, so k I bounds each; dampers
/// likewise; the energy of the volume force is at most k_vol h/2 times the sum of squares of the three mean
/// edges' changes times three, which gives each edge 3/4 k_vol h per cell. Springs at the surface of a body
/// damp a little less than their share of an interior one, and count as if they did not; of several parts all
/// springs count as those of the part that damps most for its stiffness. Liu, Bargteil,
/// O'Brien and Kavan, Fast simulation of mass-spring systems, ACM TOG 32 (2013) 214; the same with a volume
/// force, Liu, Bouaziz and Kavan, ACM TOG 36 (2017) 23.
ConstantMatrix bounding_matrix(const Body& body, double a, double b, double c);

/// Solves with a body's constant matrices for the coordinates that nothing prescribes.
class ConstantSolver {
 public:
  ConstantSolver() = default;
  ConstantSolver(const ConstantSolver&) = delete;
  ConstantSolver& operator=(const ConstantSolver&) = delete;
  virtual ~ConstantSolver() = default;

  /// Prepares to solve with a matrix. Status ok, or not_positive_definite: without mass, a body must be held.
  virtual Status prepare(const ConstantMatrix& matrix) = 0;

  /// Three right-hand sides at once, x, y and z; shape 3 x sites. Prescribed coordinates of `rhs` are
  /// ignored; those of `solution` become 0, and so do sites without a particle. Uses the threads of the
  /// system.
  virtual void solve(System<double>& system, const Field<double>& rhs, Field<double>& solution) = 0;
};

/// By eigenvectors along the axes of a box (separable.hpp). Throws InputError where they are not those of
/// the matrix.
std::unique_ptr<ConstantSolver> separable_solver(const Body& body, System<double>& system);

/// Why a body and its holds have no separable matrix, as the rest of a sentence after "separable"; empty:
/// they have one. `mask`: 1 at unknowns, 0 elsewhere; shape 3 x sites.
std::string why_not_separable(const Body& body, const Field<double>& mask);

}  // namespace mss
