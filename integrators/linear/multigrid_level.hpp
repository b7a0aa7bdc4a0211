#pragma once

#include <array>
#include <memory>

#include "core/springs/spring_system.hpp"
#include "integrators/linear/cholmod.hpp"
#include "integrators/linear/coarsening.hpp"

namespace mss {

/// Symmetric 3 x 3 blocks, one per site.
struct SiteBlocks {
  Field<float> straight;  ///< xx, yy, zz
  Field<float> mixed;     ///< yz, zx, xy
};

/// One lattice of a multigrid hierarchy: the projected tangent of a body of springs in single precision, its
/// smoother, and the next coarser lattice, if there is one.
///
/// The smoother is Chebyshev's polynomial of block-Jacobi, D^-1 A, on [lmax/4, lmax] (Adams, Brezina, Hu and
/// Tuminaro, Parallel multigrid smoothing, 2003). lmax is a bound and not an estimate, so that the cycle is
/// positive definite: an element of m particles contributes at most m times its own blocks on the diagonal,
/// a spring 2 and a cell 8, so lmax <= 2 + 6 max lambda(D^-1 D_cells).
class MultigridLevel {
 public:
  /// The body must outlive it. `mask`: 1 at unknowns, 0 elsewhere; `threads` compute products.
  MultigridLevel(const Body& body, const Field<float>& mask, int threads);
  ~MultigridLevel();
  MultigridLevel(const MultigridLevel&) = delete;
  MultigridLevel& operator=(const MultigridLevel&) = delete;

  /// Prepares for the projected matrix a M + b C + c K at positions x, plus `added` blocks on its diagonal;
  /// empty fields add nothing. Status ok, or not_positive_definite if the coarsest matrix cannot be factored.
  Status prepare(const Field<float>& x, const TangentCoefficients& sum, const SiteBlocks& added);

  /// z = one V-cycle for A z = r from z = 0. r, 0 where there is no unknown, is overwritten.
  void cycle(Field<float>& r, Field<float>& z);

 private:
  struct Range {
    std::ptrdiff_t first, last;
  };
  template <class Part>
  void for_each_range(Part&& part);

  Parallel parallel();
  void restrict_blocks(const SiteBlocks& fine, SiteBlocks& coarse);
  float largest_cell_share(const TangentCoefficients& sum);
  void invert_diagonal(const TangentCoefficients& sum);
  Status factor();
  void solve_directly(const Field<float>& r, Field<float>& z);
  void multiply(const Field<float>& p, Field<float>& out);
  void correct(Field<float>& r, Field<float>& z);
  void smooth(Field<float>& r, Field<float>& z, bool from_zero);

  const Body& body_;
  SpringSystem<float> system_;
  Field<float> mask_;
  Field<float> x_;
  TangentCoefficients sum_;
  SiteBlocks added_, diagonal_, cells_, inverse_;
  float largest_ = 2;  ///< bound on the eigenvalues of D^-1 A
  Field<float> direction_, image_;

  std::unique_ptr<Body> coarse_body_;
  std::unique_ptr<LatticeTransfer> transfer_;
  std::unique_ptr<MultigridLevel> coarse_;
  Field<float> coarse_x_, coarse_r_, coarse_z_;
  SiteBlocks coarse_added_;

  SparseMatrix matrix_;  ///< of the coarsest level
  Cholesky cholesky_;
  Eigen::VectorXd rhs_, solution_;
};

}  // namespace mss
