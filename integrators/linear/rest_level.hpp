#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/body/body.hpp"
#include "core/system/tangents.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/coarsening.hpp"
#include "integrators/linear/merged_cells.hpp"
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

/// What a lattice's particles are to the body, by site.
struct RestParticles {
  std::array<std::vector<char>, 3> unknown{};  ///< by axis: whether nothing prescribes a coordinate
  std::vector<char> own{};                     ///< whether it is the body's, and not of merged cells
  std::vector<char> follows{};                 ///< whether it hangs on larger cells; empty: none does
};

/// Those of a coarser lattice that are not the body's. A coordinate is prescribed if that of any fine
/// particle in the support of its interpolation is: then no correction pulls at a hold. `corner`: of the fine
/// lattice in the coarse one [coarse cells].
RestParticles coarsened(const Body& fine, const RestParticles& of_fine, const Body& coarse,
                        const std::array<int, 3>& corner);

inline constexpr std::ptrdiff_t sites_together = 2048;  ///< that one thread works on

/// Calls task(first, last) for ranges of sites.
template <class Task>
void for_ranges(const Parallel& parallel, const Lattice& lattice, Task&& task) {
  parallel((lattice.sites + sites_together - 1) / sites_together, [&](std::ptrdiff_t i) {
    task(i * sites_together, std::min((i + 1) * sites_together, lattice.sites));
  });
}

/// Calls task(plane) for all planes of a lattice, as many on a thread as are worth one.
template <class Task>
void for_planes(const Parallel& parallel, const Lattice& lattice, Task&& task) {
  const std::ptrdiff_t planes = lattice.planes();
  const std::ptrdiff_t group = std::max<std::ptrdiff_t>(1, sites_together / lattice.plane);
  parallel((planes + group - 1) / group, [&](std::ptrdiff_t i) {
    for (std::ptrdiff_t plane = i * group; plane < std::min((i + 1) * group, planes); ++plane) task(plane);
  });
}

/// One lattice of a multigrid hierarchy for a M + b C + c K of a body of springs at rest (rest_kernel.hpp):
/// its smoother, and the next coarser lattice, if there is one. Coarser lattices are bodies of the same
/// materials in larger cells (coarsening.hpp).
///
/// The smoother is Chebyshev's polynomial of degree two of block-Jacobi on [lmax/4, lmax] (Adams, Brezina, Hu
/// and Tuminaro, J. Comput. Phys. 188 (2003) 593). lmax is a bound and not an estimate, so that the cycle is
/// positive definite: an element of m particles is at most m times its own blocks on the diagonal, a spring 2
/// and a cell 8, so lmax <= 2 + 6 max lambda(D^-1 D_cells).
///
/// Of a body with cells of several sizes there is a lattice for each size, with smaller cells merged
/// (merged_cells.hpp). What hangs on larger cells is at rest while the others are smoothed, and what pulls at
/// it goes to its masters; interpolation from the larger cells' lattice, where these are smoothed, takes it
/// with them. That is a multigrid method with local smoothing (Brandt, Math. Comp. 31 (1977) 333; Bramble,
/// Pasciak, Wang and Xu, Math. Comp. 57 (1991) 23), symmetric and positive as the others are.
class RestLevel {
 public:
  /// With a coarser lattice where the body has larger cells too, in which its own begins at `corner` [coarse
  /// cells]; nullptr: with those of ever larger cells. The body must outlive it.
  RestLevel(const Body& body, RestParticles particles, std::unique_ptr<RestLevel> coarse = nullptr,
            const std::array<int, 3>& corner = {});
  ~RestLevel();
  RestLevel(const RestLevel&) = delete;
  RestLevel& operator=(const RestLevel&) = delete;

  /// Status ok, or not_positive_definite: of the coarsest lattice.
  Status prepare(const TangentCoefficients& sum);

  /// z() = one cycle for A z = r() from z = 0; r(), 0 where there is no unknown, is overwritten. So are those
  /// of coarser lattices; where these have particles of the body, their r() is what pulls at them. Calls
  /// parallel(count, task) as System::parallel.
  void cycle(const Parallel& parallel, Cycle kind = Cycle::v);
  /// r() -= A d for d in z(), which is overwritten; of this lattice alone.
  void subtract_product(const Parallel& parallel);

  PaddedArrays& r() { return r_; }
  PaddedArrays& z() { return z_; }
  const Lattice& lattice() const { return body_.lattice(); }

  /// Constrains particles from now on, beside prescribed coordinates: the cycle then is one in what is left.
  /// Constraints of before are gone. `of_coarser`: of particles of the body in coarser lattices.
  void constrain(const std::vector<SiteConstraint>& constraints,
                 std::span<const std::vector<SiteConstraint>> of_coarser = {});

 private:
  /// Between the body's smaller and larger cells.
  struct ToLarger {
    LatticeWindow window;  ///< the lattice in cells twice as large, in the coarser one
    PaddedArrays values;   ///< there
    std::vector<std::pair<std::ptrdiff_t, int>> pinned;  ///< prescribed coordinates whose parents are not
  };

  void connect(const Lattice& coarse);
  void connect_to_larger();
  bool is_own(std::ptrdiff_t site) const { return particles_.own[std::size_t(site)] != 0; }
  bool follows(std::ptrdiff_t site) const {
    return !particles_.follows.empty() && particles_.follows[std::size_t(site)] != 0;
  }
  Eigen::Vector3f unknown_axes(std::ptrdiff_t site) const;
  template <class Visit>
  void for_each_parent(std::ptrdiff_t site, Visit&& visit) const;
  void restrict_residual(const Parallel& parallel);
  void interpolate_correction(const Parallel& parallel);
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
  RestParticles particles_;
  PaddedArrays weights_;  ///< thirteen springs, cell, mass
  PaddedArrays inverse_;
  PaddedArrays blocks_;  ///< xx, yy, zz, yz, zx, xy
  PaddedArrays r_, z_, d_, d_next_, pressure_;
  RestStencil stencil_{};
  float largest_ = 2;  ///< bound on the eigenvalues of D^-1 A
  std::vector<SiteConstraint> constraints_;

  std::unique_ptr<Body> coarse_body_;
  std::unique_ptr<RestLevel> coarse_;
  std::array<int, 3> corner_{};  ///< of the lattice in the coarser one [coarse cells]
  RestTransfer transfer_{};
  std::optional<ToLarger> to_larger_;
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
