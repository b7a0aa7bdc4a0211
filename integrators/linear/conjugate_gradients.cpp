#include "integrators/linear/conjugate_gradients.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace mss {

namespace {

/// y = a x + b y in a range.
void combine(double a, const Field<double>& x, double b, Field<double>& y, BlockJacobi::Range range) {
  for (int axis = 0; axis < 3; ++axis) {
    const double* from = x.axis(axis);
    double* to = y.axis(axis);
#pragma omp simd
    for (std::ptrdiff_t i = range.first; i < range.last; ++i) to[i] = a * from[i] + b * to[i];
  }
}

double dot(const Field<double>& x, const Field<double>& y, BlockJacobi::Range range) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double *a = x.axis(axis), *b = y.axis(axis);
#pragma omp simd reduction(+ : sum)
    for (std::ptrdiff_t i = range.first; i < range.last; ++i) sum += a[i] * b[i];
  }
  return sum;
}

}  // namespace

void BlockJacobi::prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                          const TangentSum& sum) {
  Tangents<double>& tangents = tangents_of(system);
  if (inverse_.empty()) {
    inverse_.assign(6, AlignedArray<double>(system.size()));
    mask_ = Field<double>(system.size());
    for (const auto [site, axis] : tangents.unknowns()) mask_.axis(axis)[site] = 1;
  }
  tangents.diagonal(t, x, v, sum, blocks_);
  for (std::size_t p = 0; p < blocks_.size(); ++p) {
    const std::ptrdiff_t site = system.particles()[p];
    const Vec3 is_free = mask_.at(site);
    Eigen::Matrix3d block = is_free.asDiagonal() * blocks_[p] * is_free.asDiagonal();
    block.diagonal() += Vec3::Ones() - is_free;
    const Eigen::Matrix3d inverse = is_free.asDiagonal() * block.inverse() * is_free.asDiagonal();
    std::size_t entry = 0;
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b) inverse_[entry++][site] = inverse(a, b);
  }
}

BlockJacobi::Products BlockJacobi::apply(const Field<double>& r, Field<double>& z, Range range) const {
  const double *m[6], *rx = r.axis(0), *ry = r.axis(1), *rz = r.axis(2);
  for (std::size_t entry = 0; entry < 6; ++entry) m[entry] = inverse_[entry].data();
  double *zx = z.axis(0), *zy = z.axis(1), *zz = z.axis(2);
  double sum_rz = 0, sum_rr = 0;
#pragma omp simd reduction(+ : sum_rz, sum_rr)
  for (std::ptrdiff_t i = range.first; i < range.last; ++i) {
    zx[i] = m[0][i] * rx[i] + m[1][i] * ry[i] + m[2][i] * rz[i];
    zy[i] = m[1][i] * rx[i] + m[3][i] * ry[i] + m[4][i] * rz[i];
    zz[i] = m[2][i] * rx[i] + m[4][i] * ry[i] + m[5][i] * rz[i];
    sum_rz += rx[i] * zx[i] + ry[i] * zy[i] + rz[i] * zz[i];
    sum_rr += rx[i] * rx[i] + ry[i] * ry[i] + rz[i] * rz[i];
  }
  return {sum_rz, sum_rr};
}

Status ConjugateGradients::prepare(System<double>& system, double t, const Field<double>& x,
                                   const Field<double>& v, const TangentSum& sum, Work& work) {
  if (residual_.size() == 0)
    for (Field<double>* field : {&residual_, &z_, &direction_, &image_})
      *field = Field<double>(system.size());
  system_ = &system;
  most_iterations_ = std::max(100L, long(tangents_of(system).unknowns().size()));
  preconditioner_.prepare(system, t, x, v, sum);
  prepare_product(system, t, x, v, sum, work);
  ++work.jacobians;
  return Status::ok;
}

/// Calls part(range) for ranges of sites that do not depend on the number of threads.
template <class Part>
void ConjugateGradients::for_each_range(Part&& part) {
  constexpr std::ptrdiff_t sites = 1024;
  const std::ptrdiff_t size = system_->size();
  sums_.resize(std::size_t((size + sites - 1) / sites));
  system_->parallel(std::ptrdiff_t(sums_.size()), [&](std::ptrdiff_t i) {
    part(BlockJacobi::Range{i * sites, std::min((i + 1) * sites, size)}, sums_[std::size_t(i)]);
  });
}

/// Adds up what part(range) returns, always in the same order.
template <class Part>
auto ConjugateGradients::sum_over_ranges(Part&& part) {
  for_each_range([&](BlockJacobi::Range range, BlockJacobi::Products& sum) { sum = part(range); });
  BlockJacobi::Products total;
  for (const auto& [rz, rr] : sums_) total = {total.rz + rz, total.rr + rr};
  return total;
}

Status ConjugateGradients::solve(const Field<double>& rhs, Field<double>& solution, Work& work) {
  using Range = BlockJacobi::Range;
  using Products = BlockJacobi::Products;
  ++work.linear_solves;
  solution.array() = 0;
  residual_.array() = rhs.array() * preconditioner_.mask().array();
  auto [rz, rr] = sum_over_ranges([&](Range r) { return preconditioner_.apply(residual_, direction_, r); });
  const double target = tolerance_ * tolerance_ * rr;
  for (long iteration = 0; rr > target; ++iteration) {
    if (iteration == most_iterations_) return Status::linear_stalled;
    product(direction_, image_);
    ++work.products;
    system_->clear_prescribed(image_);
    const double curvature =
        sum_over_ranges([&](Range r) { return Products{dot(direction_, image_, r)}; }).rz;
    if (!std::isfinite(curvature)) return Status::non_finite;
    if (curvature <= 0) return Status::not_positive_definite;
    const double step = rz / curvature;
    const auto [rz_new, rr_new] = sum_over_ranges([&](Range r) {
      combine(step, direction_, 1, solution, r);
      combine(-step, image_, 1, residual_, r);
      return preconditioner_.apply(residual_, z_, r);
    });
    const double share = rz_new / rz;
    for_each_range([&](Range r, Products&) { combine(1, z_, share, direction_, r); });
    rz = rz_new;
    rr = rr_new;
  }
  return std::isfinite(rr) ? Status::ok : Status::non_finite;
}

}  // namespace mss
