#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "core/body/body.hpp"

namespace mss {

/// Strains of a body of springs, as two fields of its lattice say them: Green's at positions x, or, with a
/// displacement, their derivative at x along it. Both must outlive it.
struct StrainField {
  const Field<double>& positions;
  const Field<double>* displacement = nullptr;
};

/// A smooth displacement recovered from that of a lattice, and what the lattice's energy has more than a
/// continuum's of it: that is the error of the lattice.
///
/// Of a lattice with energy a_h(u_h, u_h) / 2 and forces f at particles, the potential is Pi_h, least at u_h;
/// of the continuum Pi, least at u. With I u the lattice's displacement that is u at particles, Iu the
/// trilinear one between these, and w = u - Iu the rest, which vanishes at particles,
///   Pi_h(u_h) = Pi_h(I u) - a_h(d, d) / 2,  d = u_h - I u,
/// where d is of second order in the cell size h, so that the last term is of fourth. The work of forces on a
/// displacement under the only load is J = -2 Pi, hence
///   J(u) - J(u_h) = a_h(I u, I u) - a(u, u) + 2 f(w) + O(h^4).
/// Since a(u, w) = f(w) at equilibrium, a(u, u) = a(Iu, Iu) - a(w, w) + 2 f(w), and
///   J(u) - J(u_h) = a_h(I u, I u) - a(Iu, Iu) + a(w, w) + O(h^4),
/// whatever acts on the body. The first two terms are what springs and k_vol of cells store beyond a
/// continuum that deforms trilinearly, positive or negative: it depends on t; the third is what trilinear
/// cells lack. All are sums over cells of second differences, to which u_h in place of u makes a difference
/// of fourth order. The same with two displacements u and z is the bilinear form of the error of other
/// quantities (integrators/analysis/error_estimate.hpp).
///
/// w is what second derivatives along edges make: half the second difference of an edge times s (s - 1), s
/// from 0 to 1 along the edge, and linear between the four edges of a cell along an axis. That of an edge is
/// the mean of those at its two ends, taken to the next edges in line, of cells across a face that hold the
/// same parts: materials that meet have a kink between them. At a surface the other end's stands for it; of a
/// cell without such a neighbour along an axis it is unknown, and 0. Any quadratic displacement is recovered
/// exactly, but for that.
///
/// In a nearly incompressible solid a trilinear displacement stores far too much by its change of volume, and
/// what cancels that is recovered too badly. With m the mean trace of strain in a cell, t that of Iu less m,
/// and q that of the whole less m, the last two terms are, of what C12 multiplies, -m^2 - t^2 + (q - t)^2 or
/// -m^2 + q^2 - 2 q t; there q is recovered as linear, from differences between the means of neighbours.
///
/// Strains are Green's, so that nothing changes when the body rotates; to first order about rest they are
/// those of linear elasticity, which the above is about. C is that of the springs (cubic_stiffness()), for
/// calibrated ones isotropic with E and nu. Of a cell that is filled in part both energies are those of what
/// is filled, the continuum's by octants.
class DisplacementRecovery {
 public:
  /// The body must outlive it. Throws InputError for what has no elasticity that all its cells share: springs
  /// shared as `uniform`, one diagonal a face, or C that is not positive definite.
  explicit DisplacementRecovery(const Body& body);

  /// Lower corners of the cells, by id: the place in Body::for_each_cell, in site order.
  const std::vector<std::ptrdiff_t>& cells() const { return cells_; }

  /// Of two fields of strain.
  struct Products {
    std::vector<double> error{};  ///< a_h - a + a(w, w) of every cell, by id [J]
    double stored = 0;            ///< a_h of all [J]
    double error_of_all() const;
  };
  Products products(const StrainField& a, const StrainField& b) const;

  /// Share of the cells without any neighbour along some axis: there the second derivative is unknown.
  double share_alone() const;
  /// Whether some cell is not full.
  bool has_partial_cells() const;

 private:
  using Matrix = Eigen::Matrix3d;
  /// By axis and by edge along it, in the order of their lower corners.
  using SecondDifferences = std::array<std::array<Vec3, 4>, 3>;
  /// A spring of a cell: between which corners, and with how much stiffness of this cell [N/m].
  struct CellSpring {
    int a, b;
    double stiffness;
  };
  /// What cells of one content have.
  struct Kind {
    std::vector<CellSpring> springs;          ///< one between two corners
    double volume = 0;                        ///< k_vol [Pa]
    double fill = 0;                          ///< f
    std::array<CubicStiffness, 8> elastic{};  ///< of what is filled of each octant, which has a Gauss point
    std::vector<int> parts;                   ///< ascending
  };
  /// Of one cell.
  struct CellStrains {
    std::array<double, 28> springs;         ///< along each
    double volume;                          ///< trace of the mean,
    Vec3 volume_slope;                      ///< and what it changes by from side to side
    std::array<Matrix, 8> trilinear, rest;  ///< at Gauss points: of Iu and w
  };

  Kind kind_of(const CellContent& content) const;
  /// The id of the cell across a face that holds the same parts; -1: there is none.
  int neighbour(std::size_t cell, int axis, int step) const;
  SecondDifferences second_differences(std::size_t cell, const Field<double>& field) const;
  /// Trace of the mean strain of every cell.
  std::vector<double> volume_strains(const StrainField& field) const;
  Vec3 slope(std::size_t cell, const std::vector<double>& of_cells) const;
  void find_strains(std::size_t cell, const StrainField& field, const std::vector<double>& volumes,
                    CellStrains& strains) const;

  const Body& body_;
  std::vector<std::ptrdiff_t> cells_;
  std::vector<int> cell_at_;  ///< by site; -1: none
  std::vector<Kind> kinds_;
  std::vector<std::size_t> kind_;  ///< by cell
};

}  // namespace mss
