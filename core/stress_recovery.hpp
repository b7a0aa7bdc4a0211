#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/body.hpp"

namespace mss {

/// One symmetric tensor per cell, by cell id: the place in Body::for_each_cell, in site order.
using CellStress = std::vector<Eigen::Matrix3d>;

/// The gradient of such a field: its derivatives along the axes of the lattice at rest.
using CellStressGradient = std::vector<std::array<Eigen::Matrix3d, 3>>;

/// Strain of a spring of a cell along its own direction, and what the cell's mean deformation makes of it.
struct SpringStrain {
  double own, mean;
};

/// Stress in the cells of a body of springs, from the cells' own forces, and what its variation from cell to
/// cell says of the error of the lattice.
///
/// The stress of a cell is its virial, (1/V0) sum_p f_p (x) X_p over its corners, with f_p its own springs'
/// and volume force's and X_p at rest: the first Piola-Kirchhoff stress P, which turns with the body. It is
/// taken back to the cell at rest, S = F^-1 P, spring by spring: a spring D of tension T that has become d
/// gives T/|d| D (x) D, and the volume force k_vol (J^2 - J) (F^T F)^-1. This second Piola-Kirchhoff stress
/// is symmetric and stays as it is when the body rotates; to first order about rest all stresses are the
/// same.
///
/// A trilinear cell has one stress; where the true one varies linearly in it, by g_i a metre along axis i,
/// the difference has the energy
///   eta^2 = h^5/12 sum_i g_i : C^-1 : g_i  [J],
/// with C the elasticity of the springs in the cell. Zienkiewicz and Zhu, Int. J. Numer. Meth. Engng 24
/// (1987) 337, with a gradient by least squares in place of averages at corners.
///
/// Of a cell that is filled in part, the stress is that of what is filled, sigma / f, and its energy f times
/// that of a full one. Gradients are taken among cells that hold the same parts, since stress jumps where
/// materials meet.
class StressRecovery {
 public:
  /// The body must outlive it. Throws InputError for what has no elasticity that all its cells share: springs
  /// shared as `uniform`, one diagonal a face, or C that is not positive definite.
  explicit StressRecovery(const Body& body);

  /// Lower corners of the cells, by id.
  const std::vector<std::ptrdiff_t>& cells() const { return cells_; }

  /// S of every cell at positions x [Pa].
  CellStress stress(const Field<double>& x) const;
  /// Its derivative at x along a displacement [Pa].
  CellStress stress_change(const Field<double>& x, const Field<double>& displacement) const;

  /// By least squares of the differences to the neighbours across faces that hold the same parts [Pa/m]:
  /// between two of them the central difference, at a surface the one-sided one, and 0 along an axis on which
  /// there is none.
  CellStressGradient gradient(const CellStress& stress) const;

  /// h^5/12 sum_i a_i : C^-1 : b_i of every cell [J].
  std::vector<double> error_products(const CellStressGradient& a, const CellStressGradient& b) const;

  /// Green's strain of every cell's springs at positions x, cell by cell.
  std::vector<SpringStrain> spring_strains(const Field<double>& x) const;
  /// Its derivative at x along a displacement.
  std::vector<SpringStrain> spring_strain_change(const Field<double>& x,
                                                 const Field<double>& displacement) const;
  /// What the springs of every cell store beyond what they would if it deformed evenly, sum k L^2 (a b - mean
  /// a mean b) [J]: a cell of springs bends stiffly, by more or less than a continuum's linear stress.
  std::vector<double> uneven_products(const std::vector<SpringStrain>& a,
                                      const std::vector<SpringStrain>& b) const;

  /// Share of the cells without any neighbour along some axis: there the gradient along it is unknown.
  double share_alone() const;
  /// Whether some cell is not full.
  bool has_partial_cells() const;

 private:
  /// A spring of a cell: between which corners, and with how much stiffness of this cell [N/m].
  struct CellSpring {
    int a, b;
    double stiffness;
  };
  /// What cells of one content have.
  struct Kind {
    std::vector<CellSpring> springs;
    double volume = 0;       ///< k_vol [Pa]
    double fill = 0;         ///< f
    CubicStiffness elastic;  ///< of what is filled
    std::vector<int> parts;  ///< ascending
  };
  Kind kind_of(const CellContent& content) const;
  /// The id of the cell across a face that holds the same parts; -1: there is none.
  int neighbour(std::size_t cell, int axis, int step) const;

  const Body& body_;
  std::vector<std::ptrdiff_t> cells_;
  std::vector<int> cell_at_;  ///< by site; -1: none
  std::vector<Kind> kinds_;
  std::vector<std::size_t> kind_;  ///< by cell
};

/// The fewest cells whose indicators add up to at least a share of all, most first (Doerfler, SIAM J. Numer.
/// Anal. 33 (1996) 1106). Indicators must not be negative; of equal ones the lower id is first.
std::vector<std::size_t> doerfler_marking(const std::vector<double>& indicators, double share);

}  // namespace mss
