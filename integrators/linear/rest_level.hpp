#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <memory>
#include <vector>

#include "core/body/body.hpp"
#include "core/system/tangents.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/coarsening.hpp"
#include "integrators/linear/rest_kernel.hpp"

namespace mss {

/// Single-precision numbers over the sites of a lattice, several of them a site, with room for what lies a
/// plane, a row and a site before and behind.
class PaddedArrays {
 public:
  PaddedArrays() = default;
  PaddedArrays(const Lattice& lattice, int count);

  float* operator[](int i) { return data_.data() + stride_ * i + before_; }
  const float* operator[](int i) const { return data_.data() + stride_ * i + before_; }
  int count() const { return count_; }
  void clear() { data_.fill(0); }

 private:
  int count_ = 0;
  std::ptrdiff_t stride_ = 0, before_ = 0;
  AlignedArray<float> data_;
};

enum class Cycle {
  v,        ///< smooth, correct by coarser lattices, smooth
  additive  ///< the sum of what block-Jacobi says on every lattice
};

/// What a particle meets beside springs: directions in which it cannot move, as a projection onto them, and a
/// matrix that is added to its own block.
struct SiteConstraint {
  std::ptrdiff_t site;
  Eigen::Matrix3f held, added;
};

/// One lattice of a multigrid hierarchy for a M + b C + c K of a body of springs at rest (rest_kernel.hpp):
/// its smoother, and the next coarser lattice, if there is one. Coarser lattices are bodies of the same
/// materials in larger cells (coarsening.hpp).
///
/// The smoother is Chebyshev's polynomial of degree two of block-Jacobi on [lmax/4, lmax] (Adams, Brezina, Hu
/// and Tuminaro, J. Comput. Phys. 188 (2003) 593). lmax is a bound and not an estimate, so that the cycle is
/// positive definite: an element of m particles is at most m times its own blocks on the diagonal, a spring 2
/// and a cell 8, so lmax <= 2 + 6 max lambda(D^-1 D_cells).
class RestLevel {
 public:
  /// `unknown`: whether nothing prescribes a coordinate, 3 axes of sites. The body must outlive it.
  RestLevel(const Body& body, const std::array<std::vector<char>, 3>& unknown);
  ~RestLevel();
  RestLevel(const RestLevel&) = delete;
  RestLevel& operator=(const RestLevel&) = delete;

  /// Status ok, or not_positive_definite: of the coarsest lattice.
  Status prepare(const TangentCoefficients& sum);

  /// z() = one cycle for A z = r() from z = 0; r(), 0 where there is no unknown, is overwritten. Calls
  /// parallel(count, task) as System::parallel.
  void cycle(const Parallel& parallel, Cycle kind = Cycle::v);
  /// r() -= A d for d in z(), which is overwritten.
  void subtract_product(const Parallel& parallel);

  PaddedArrays& r() { return r_; }
  PaddedArrays& z() { return z_; }
  const RestStencil& stencil() const { return stencil_; }
  const Lattice& lattice() const { return body_.lattice(); }

  /// Constrains particles from now on, beside prescribed coordinates: the cycle then is one in what is left.
  /// Constraints of before are gone.
  void constrain(const std::vector<SiteConstraint>& constraints);

  /// Calls task(first, last) for ranges of sites.
  template <class Task>
  void for_ranges(const Parallel& parallel, Task&& task) const {
    const std::ptrdiff_t sites = lattice().sites;
    parallel((sites + range_size - 1) / range_size,
             [&](std::ptrdiff_t i) { task(i * range_size, std::min((i + 1) * range_size, sites)); });
  }
  static constexpr std::ptrdiff_t range_size = 2048;

 private:
  Status prepare_own(const TangentCoefficients& sum);
  void set_weights(const TangentCoefficients& sum);
  void set_blocks();
  float largest_cell_share() const;
  Eigen::Matrix3f inverse_block(const SiteConstraint& constraint) const;
  Status invert();
  Eigen::Matrix3f leading_directions(std::ptrdiff_t site, const Eigen::Matrix3f& sum) const;
  void factor_constraints();
  void smooth(const Parallel& parallel, float keep, float add, bool update);
  void correct(const Parallel& parallel, Cycle kind);
  void solve_directly(const Parallel& parallel);

  const Body& body_;
  std::array<std::vector<char>, 3> unknown_;
  PaddedArrays weights_;  ///< thirteen springs, cell, mass
  PaddedArrays inverse_;
  PaddedArrays blocks_;  ///< xx, yy, zz, yz, zx, xy
  PaddedArrays r_, z_, d_, d_next_, pressure_;
  RestStencil stencil_{};
  float largest_ = 2;  ///< bound on the eigenvalues of D^-1 A
  std::vector<SiteConstraint> constraints_;

  std::unique_ptr<Body> coarse_body_;
  std::unique_ptr<RestLevel> coarse_;
  RestTransfer transfer_{};
  std::vector<float> scratch_;  ///< of every plane

  // Of the coarsest lattice.
  std::vector<std::pair<std::ptrdiff_t, int>> rows_;  ///< of its matrix A: site and axis
  std::array<std::vector<std::ptrdiff_t>, 3> row_of_;
  std::ptrdiff_t padded_rows_ = 0;
  AlignedArray<float> inverse_matrix_, rhs_, solution_;
  Eigen::MatrixXf normals_, columns_;  ///< N, a column for every constrained direction, and A^-1 N
  Eigen::LLT<Eigen::MatrixXf> schur_;  ///< N^T A^-1 N + C, C the compliance along these: 0 where held
};

}  // namespace mss
