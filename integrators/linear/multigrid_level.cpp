#include "integrators/linear/multigrid_level.hpp"

#include <algorithm>
#include <cmath>

namespace mss {

namespace {

constexpr int smoothing_degree = 2;
constexpr float smoothed_share = 0.25F;  ///< of the spectrum's top is left to the coarser levels

/// Bodies of no more cells along their longest side are not coarsened.
constexpr int coarsest_cells = 5;

/// Below this a second thread costs more than it saves.
constexpr std::size_t springs_per_thread = 20000;

int longest(const Body& body) {
  const auto size = body.config().voxels.size();
  return *std::max_element(size.begin(), size.end());
}

int threads_for(const Body& body, int threads) {
  return std::clamp(int(body.spring_count() / springs_per_thread), 1, threads);
}

/// A coarse particle is held if any fine particle in the support of its interpolation is: then no correction
/// pulls at a hold.
Field<float> coarsened_mask(const Body& fine, const Field<float>& fine_mask, const Body& coarse) {
  Field<float> mask(coarse.lattice().size);
  const Lattice &from = fine.lattice(), &to = coarse.lattice();
  for (const std::ptrdiff_t site : coarse.sites())
    for (int axis = 0; axis < 3; ++axis) mask.axis(axis)[site] = 1;
  for (const std::ptrdiff_t site : fine.sites()) {
    const std::array<int, 3> at = from.coordinates(site);
    for (int axis = 0; axis < 3; ++axis) {
      if (fine_mask.axis(axis)[site] != 0) continue;
      for (int c = 0; c < 8; ++c)  // the coarse particles it is interpolated from
        mask.axis(axis)[to.site((at[0] + corner_bit(c, 0)) / 2, (at[1] + corner_bit(c, 1)) / 2,
                                (at[2] + corner_bit(c, 2)) / 2)] = 0;
    }
  }
  return mask;
}

SiteBlocks site_blocks(std::ptrdiff_t sites) { return {Field<float>(sites), Field<float>(sites)}; }

}  // namespace

MultigridLevel::MultigridLevel(const Body& body, const Field<float>& mask, int threads)
    : body_(body),
      system_(body, Environment{}, {.threads = threads_for(body, threads)}),
      mask_(mask),
      x_(system_.size()),
      diagonal_(site_blocks(system_.size())),
      cells_(site_blocks(system_.size())),
      inverse_(site_blocks(system_.size())),
      direction_(system_.size()),
      image_(system_.size()) {
  if (longest(body) <= coarsest_cells) return;
  coarse_body_ = std::make_unique<Body>(coarsened(body.config()));
  transfer_ = std::make_unique<LatticeTransfer>(body.lattice(), coarse_body_->lattice());
  coarse_ =
      std::make_unique<MultigridLevel>(*coarse_body_, coarsened_mask(body, mask, *coarse_body_), threads);
  for (Field<float>* field : {&coarse_x_, &coarse_r_, &coarse_z_})
    *field = Field<float>(coarse_body_->lattice().size);
}

MultigridLevel::~MultigridLevel() = default;

/// Calls part(range) for ranges of sites, on all threads.
template <class Part>
void MultigridLevel::for_each_range(Part&& part) {
  constexpr std::ptrdiff_t sites = 2048;
  const std::ptrdiff_t size = system_.size();
  system_.parallel((size + sites - 1) / sites, [&](std::ptrdiff_t i) {
    part(Range{i * sites, std::min((i + 1) * sites, size)});
  });
}

Parallel MultigridLevel::parallel() {
  return [this](std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) {
    system_.parallel(count, task);
  };
}

Status MultigridLevel::prepare(const Field<float>& x, const TangentCoefficients& sum,
                               const SiteBlocks& added) {
  x_ = x;
  sum_ = sum;
  sum_.kind = Tangent::projected;
  added_ = added;
  if (!coarse_) return factor();
  invert_diagonal(sum_);
  largest_ = 2 + 6 * largest_cell_share(sum_);
  coarsen_positions(body_, x_, *coarse_body_, coarse_x_);
  if (added_.straight.size() != 0) restrict_blocks(added_, coarse_added_);
  return coarse_->prepare(coarse_x_, sum_, coarse_added_);
}

/// The sums of a block matrix's rows, with interpolation on both sides.
void MultigridLevel::restrict_blocks(const SiteBlocks& fine, SiteBlocks& coarse) {
  if (coarse.straight.size() == 0) coarse = site_blocks(coarse_body_->lattice().size);
  transfer_->restrict_to(fine.straight, coarse.straight, parallel());
  transfer_->restrict_to(fine.mixed, coarse.mixed, parallel());
}

/// The inverse blocks, with zero rows and columns at prescribed coordinates.
void MultigridLevel::invert_diagonal(const TangentCoefficients& sum) {
  system_.diagonal_blocks(x_, sum, diagonal_.straight, diagonal_.mixed);
  for (const std::ptrdiff_t site : body_.sites())
    for (int axis = 0; axis < 3; ++axis)
      diagonal_.straight.axis(axis)[site] += static_cast<float>(sum.mass * body_.mass(site));
  if (added_.straight.size() != 0) {
    diagonal_.straight.array() += added_.straight.array();
    diagonal_.mixed.array() += added_.mixed.array();
  }
  for_each_range([&](Range range) {
    const float *mx = mask_.axis(0), *my = mask_.axis(1), *mz = mask_.axis(2);
    const float *xx = diagonal_.straight.axis(0), *yy = diagonal_.straight.axis(1),
                *zz = diagonal_.straight.axis(2), *yz = diagonal_.mixed.axis(0),
                *zx = diagonal_.mixed.axis(1), *xy = diagonal_.mixed.axis(2);
    float *ixx = inverse_.straight.axis(0), *iyy = inverse_.straight.axis(1),
          *izz = inverse_.straight.axis(2), *iyz = inverse_.mixed.axis(0), *izx = inverse_.mixed.axis(1),
          *ixy = inverse_.mixed.axis(2);
#pragma omp simd
    for (std::ptrdiff_t i = range.first; i < range.last; ++i) {
      const float scale = (xx[i] + yy[i]) + zz[i], unit = scale > 0 ? 3 / scale : 1;
      const float a = mx[i] * (unit * xx[i]) + (1 - mx[i]), b = my[i] * (unit * yy[i]) + (1 - my[i]),
                  c = mz[i] * (unit * zz[i]) + (1 - mz[i]), d = my[i] * mz[i] * (unit * yz[i]),
                  e = mz[i] * mx[i] * (unit * zx[i]), f = mx[i] * my[i] * (unit * xy[i]);
      const float det = a * (b * c - d * d) - f * (f * c - d * e) + e * (f * d - b * e);
      const float over = unit / det;
      ixx[i] = mx[i] * over * (b * c - d * d);
      iyy[i] = my[i] * over * (a * c - e * e);
      izz[i] = mz[i] * over * (a * b - f * f);
      iyz[i] = my[i] * mz[i] * over * (f * e - a * d);
      izx[i] = mz[i] * mx[i] * over * (f * d - b * e);
      ixy[i] = mx[i] * my[i] * over * (d * e - f * c);
    }
  });
}

/// A bound on the largest eigenvalue of D^-1 D_cells over all particles: of a 3 x 3 matrix M with real
/// eigenvalues it is at most t/3 + sqrt(2/3 (tr M^2 - t^2/3)), t = tr M (Wolkowicz and Styan, 1980).
float MultigridLevel::largest_cell_share(const TangentCoefficients& sum) {
  const BodyConfig& config = body_.config();
  if (config.fold_guard == 0 && !config.any_part([](const Part& part) { return part.springs.volume > 0; }))
    return 0;
  system_.diagonal_blocks(x_, sum, cells_.straight, cells_.mixed, /*springs=*/false);
  float largest = 0;
  for (const std::ptrdiff_t site : body_.sites()) {
    const auto at = [&](const SiteBlocks& blocks) {
      const Eigen::Vector3f s = blocks.straight.at(site).cast<float>(),
                            m = blocks.mixed.at(site).cast<float>();
      Eigen::Matrix3f block;
      block << s[0], m[2], m[1], m[2], s[1], m[0], m[1], m[0], s[2];
      return block;
    };
    const Eigen::Matrix3f ratio = at(inverse_) * at(cells_);
    const float t = ratio.trace(), squared = (ratio.array() * ratio.transpose().array()).sum();
    largest = std::max(largest, t / 3 + std::sqrt(std::max(0.0F, (squared - t * t / 3) * 2 / 3)));
  }
  return largest;
}

Status MultigridLevel::factor() {
  Tangents<float>& tangents = *system_.tangents();
  if (matrix_.rows() == 0) matrix_ = tangents.pattern();
  tangents.values(0, x_, x_, sum_, matrix_);
  const std::vector<FreeDof>& unknowns = tangents.unknowns();
  const auto is_free = [&](int row) {
    const auto [site, axis] = unknowns[std::size_t(row)];
    return mask_.axis(axis)[site] != 0;
  };
  for (int row = 0; row < matrix_.rows(); ++row)
    for (SparseMatrix::InnerIterator entry(matrix_, row); entry; ++entry) {
      const auto [site, axis] = unknowns[std::size_t(row)];
      const auto [other, other_axis] = unknowns[std::size_t(entry.col())];
      if (added_.straight.size() != 0 && site == other)
        entry.valueRef() += axis == other_axis ? double(added_.straight.axis(axis)[site])
                                               : double(added_.mixed.axis(3 - axis - other_axis)[site]);
      if (!is_free(row) || !is_free(int(entry.col()))) entry.valueRef() = row == entry.col() ? 1 : 0;
    }
  return cholesky_.factor(matrix_);
}

void MultigridLevel::solve_directly(const Field<float>& r, Field<float>& z) {
  const std::vector<FreeDof>& unknowns = system_.tangents()->unknowns();
  rhs_.resize(Eigen::Index(unknowns.size()));
  double* out = rhs_.data();
  for (const auto [site, axis] : unknowns) *out++ = double(r.axis(axis)[site] * mask_.axis(axis)[site]);
  cholesky_.solve(rhs_, solution_);
  const double* in = solution_.data();
  for (const auto [site, axis] : unknowns) z.axis(axis)[site] = static_cast<float>(*in++);
}

/// out = A p; prescribed coordinates of `out` may have any value.
void MultigridLevel::multiply(const Field<float>& p, Field<float>& out) {
  system_.tangents()->product(0, x_, x_, sum_, p, out);
  if (added_.straight.size() == 0) return;
  for_each_range([&](Range range) {
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      const float *straight = added_.straight.axis(a), *ab = added_.mixed.axis(c), *ac = added_.mixed.axis(b);
      const float *pa = p.axis(a), *pb = p.axis(b), *pc = p.axis(c);
      float* to = out.axis(a);
#pragma omp simd
      for (std::ptrdiff_t i = range.first; i < range.last; ++i)
        to[i] += straight[i] * pa[i] + (ab[i] * pb[i] + ac[i] * pc[i]);
    }
  });
}

/// Chebyshev iterations: z += p(D^-1 A) D^-1 r. r must be the residual of z on entry; from zero z is
/// overwritten. r, of any value at prescribed coordinates, is the residual of z but for the last step's
/// change, which is in direction_.
void MultigridLevel::smooth(Field<float>& r, Field<float>& z, bool from_zero) {
  const float upper = largest_, lower = smoothed_share * largest_;
  const float middle = (upper + lower) / 2, radius = (upper - lower) / 2;
  float rho = radius / middle;
  for (int step = 0; step < smoothing_degree; ++step) {
    float keep = 0, add = 1 / middle;
    if (step > 0) {
      multiply(direction_, image_);
      const float next = 1 / (2 * middle / radius - rho);
      keep = next * rho;
      add = 2 * next / radius;
      rho = next;
    }
    for_each_range([&](Range range) {
      const float *xx = inverse_.straight.axis(0), *yy = inverse_.straight.axis(1),
                  *zz = inverse_.straight.axis(2), *yz = inverse_.mixed.axis(0), *zx = inverse_.mixed.axis(1),
                  *xy = inverse_.mixed.axis(2);
      float *rx = r.axis(0), *ry = r.axis(1), *rz = r.axis(2);
      float *dx = direction_.axis(0), *dy = direction_.axis(1), *dz = direction_.axis(2);
      float *zx_ = z.axis(0), *zy_ = z.axis(1), *zz_ = z.axis(2);
      const float *ax = image_.axis(0), *ay = image_.axis(1), *az = image_.axis(2);
      const float change = step > 0 ? 1.0F : 0.0F, old = from_zero && step == 0 ? 0.0F : 1.0F;
#pragma omp simd
      for (std::ptrdiff_t i = range.first; i < range.last; ++i) {
        const float sx = rx[i] - change * ax[i], sy = ry[i] - change * ay[i], sz = rz[i] - change * az[i];
        rx[i] = sx;
        ry[i] = sy;
        rz[i] = sz;
        dx[i] = keep * dx[i] + add * (xx[i] * sx + xy[i] * sy + zx[i] * sz);
        dy[i] = keep * dy[i] + add * (xy[i] * sx + yy[i] * sy + yz[i] * sz);
        dz[i] = keep * dz[i] + add * (zx[i] * sx + yz[i] * sy + zz[i] * sz);
        zx_[i] = old * zx_[i] + dx[i];
        zy_[i] = old * zy_[i] + dy[i];
        zz_[i] = old * zz_[i] + dz[i];
      }
    });
  }
}

/// r -= A d, then the coarser lattice's correction, d, is added to z and r -= A d again.
void MultigridLevel::correct(Field<float>& r, Field<float>& z) {
  const auto subtract_image = [&] {
    multiply(direction_, image_);
    for_each_range([&](Range range) {
      for (int a = 0; a < 3; ++a) {
        float* to = r.axis(a);
        const float *image = image_.axis(a), *mask = mask_.axis(a);
#pragma omp simd
        for (std::ptrdiff_t i = range.first; i < range.last; ++i) to[i] -= mask[i] * image[i];
      }
    });
  };
  subtract_image();
  transfer_->restrict_to(r, coarse_r_, parallel());
  coarse_r_.array() *= coarse_->mask_.array();
  coarse_->cycle(coarse_r_, coarse_z_);
  direction_.array() = 0;
  transfer_->interpolate_add(coarse_z_, direction_, parallel());
  for_each_range([&](Range range) {
    for (int a = 0; a < 3; ++a) {
      float *d = direction_.axis(a), *to = z.axis(a);
      const float* mask = mask_.axis(a);
#pragma omp simd
      for (std::ptrdiff_t i = range.first; i < range.last; ++i) {
        d[i] *= mask[i];
        to[i] += d[i];
      }
    }
  });
  subtract_image();
}

void MultigridLevel::cycle(Field<float>& r, Field<float>& z) {
  if (!coarse_) return solve_directly(r, z);
  smooth(r, z, /*from_zero=*/true);
  correct(r, z);
  smooth(r, z, /*from_zero=*/false);
}

}  // namespace mss
