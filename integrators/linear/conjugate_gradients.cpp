#include "integrators/linear/conjugate_gradients.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "integrators/linear/unknowns.hpp"

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
                          const TangentCoefficients& sum, const Field<double>& mask) {
  if (inverse_.empty()) inverse_.assign(6, AlignedArray<double>(system.size()));
  tangents_of(system).diagonal(t, x, v, sum, blocks_);
  for (std::size_t p = 0; p < blocks_.size(); ++p) {
    const std::ptrdiff_t site = system.particles()[p];
    const Vec3 is_free = mask.at(site);
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
                                   const Field<double>& v, const TangentCoefficients& sum, Work& work) {
  if (residual_.size() == 0) {
    for (Field<double>* field : {&residual_, &z_, &direction_, &image_})
      *field = Field<double>(system.size());
    mask_ = mask_of_unknowns(system);
  }
  system_ = &system;
  most_iterations_ = std::max(100L, long(system.ranks().sum(double(tangents_of(system).unknowns().size()))));
  prepare_product(system, t, x, v, sum, work);
  ++work.jacobians;
  return prepare_preconditioner(system, t, x, v, sum, work);
}

Status ConjugateGradients::prepare_preconditioner(System<double>& system, double t, const Field<double>& x,
                                                  const Field<double>& v, const TangentCoefficients& sum,
                                                  Work&) {
  block_jacobi_.prepare(system, t, x, v, sum, mask_);
  return Status::ok;
}

ConjugateGradients::Products ConjugateGradients::precondition(const std::function<void(Range)>& update,
                                                              const Field<double>& r, Field<double>& z,
                                                              double) {
  return sum_over_ranges([&](Range range) {
    update(range);
    return block_jacobi_.apply(r, z, range);
  });
}

ConjugateGradients::Products ConjugateGradients::precondition_whole(
    const std::function<void(Range)>& update, const Field<double>& r, Field<double>& z, double enough,
    const std::function<void(double)>& apply) {
  Products products = sum_over_ranges([&](Range range) {
    update(range);
    return Products{0, dot(r, r, range)};
  });
  if (!(products.rr > enough) || !std::isfinite(products.rr)) return products;
  apply(std::sqrt(products.rr));
  products.rz = sum_over_ranges([&](Range range) { return Products{dot(r, z, range)}; }).rz;
  return products;
}

ConjugateGradients::Products ConjugateGradients::sum_over_ranges(const std::function<Products(Range)>& part) {
  constexpr std::ptrdiff_t sites = 1024, together = 4;  // some 2 us
  const std::ptrdiff_t size = system_->size();
  sums_.resize(std::size_t((size + sites - 1) / sites));
  parallel_in_groups(*system_, std::ptrdiff_t(sums_.size()), together, [&](std::ptrdiff_t i) {
    sums_[std::size_t(i)] = part({i * sites, std::min((i + 1) * sites, size)});
  });
  Products total;
  for (const auto& [rz, rr] : sums_) total = {total.rz + rz, total.rr + rr};
  std::array<double, 2> of_all{total.rz, total.rr};
  system_->ranks().sum(of_all);
  return {of_all[0], of_all[1]};
}

Status ConjugateGradients::solve(const Field<double>& rhs, Field<double>& solution, Work& work) {
  ++work.linear_solves;
  solution.array() = 0;
  residual_.array() = rhs.array() * mask_.array();
  auto [rz, rr] = precondition([](Range) {}, residual_, direction_, 0);
  // What rounding leaves of a right side along directions that planes hold, and a preconditioner moves there.
  system_->clear_prescribed(residual_);
  system_->clear_prescribed(direction_);
  const double target = tolerance_ * tolerance_ * rr;
  for (long iteration = 0; rr > target; ++iteration) {
    if (iteration == most_iterations_) return Status::linear_stalled;
    if (rz <= 0) return Status::not_positive_definite;
    product(direction_, image_);
    ++work.products;
    system_->clear_prescribed(image_);
    const double curvature =
        sum_over_ranges([&](Range r) { return Products{dot(direction_, image_, r)}; }).rz;
    if (!std::isfinite(curvature)) return Status::non_finite;
    if (curvature <= 0) return Status::not_positive_definite;
    const double step = rz / curvature;
    const auto update = [&](Range r) {
      combine(step, direction_, 1, solution, r);
      combine(-step, image_, 1, residual_, r);
    };
    const auto [rz_new, rr_new] = precondition(update, residual_, z_, target);
    system_->clear_prescribed(z_);
    const double share = rz_new / rz;
    sum_over_ranges([&](Range r) {
      combine(1, z_, share, direction_, r);
      return Products{};
    });
    rz = rz_new;
    rr = rr_new;
  }
  return std::isfinite(rr) ? Status::ok : Status::non_finite;
}

}  // namespace mss
