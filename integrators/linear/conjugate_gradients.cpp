#include "integrators/linear/conjugate_gradients.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace mss {

void BlockJacobi::prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                          const TangentSum& sum) {
  if (inverse_.empty()) {
    inverse_.assign(6, AlignedArray<double>(system.size()));
    mask_ = Field<double>(system.size());
    for (const auto [site, axis] : system.unknowns()) mask_.axis(axis)[site] = 1;
  }
  system.tangent_diagonal(t, x, v, sum, blocks_);
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

BlockJacobi::Products BlockJacobi::apply(const Field<double>& r, Field<double>& z) const {
  const double *m[6], *rx = r.axis(0), *ry = r.axis(1), *rz = r.axis(2);
  for (std::size_t entry = 0; entry < 6; ++entry) m[entry] = inverse_[entry].data();
  double *zx = z.axis(0), *zy = z.axis(1), *zz = z.axis(2);
  double sum_rz = 0, sum_rr = 0;
#pragma omp simd reduction(+ : sum_rz, sum_rr)
  for (std::ptrdiff_t i = 0; i < inverse_.front().size(); ++i) {
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
  most_iterations_ = std::max(100L, long(system.unknowns().size()));
  preconditioner_.prepare(system, t, x, v, sum);
  prepare_product(system, t, x, v, sum, work);
  ++work.jacobians;
  return Status::ok;
}

Status ConjugateGradients::solve(const Field<double>& rhs, Field<double>& solution, Work& work) {
  ++work.linear_solves;
  solution.array() = 0;
  residual_.array() = rhs.array() * preconditioner_.mask().array();
  auto [rz, rr] = preconditioner_.apply(residual_, z_);
  direction_ = z_;
  const double target = tolerance_ * tolerance_ * rr;
  for (long iteration = 0; rr > target; ++iteration) {
    if (iteration == most_iterations_) return Status::linear_stalled;
    product(direction_, image_);
    ++work.products;
    system_->clear_prescribed(image_);
    const double curvature = direction_.array().matrix().dot(image_.array().matrix());
    if (!std::isfinite(curvature)) return Status::non_finite;
    if (curvature <= 0) return Status::not_positive_definite;
    const double step = rz / curvature;
    solution.array() += step * direction_.array();
    residual_.array() -= step * image_.array();
    const auto [rz_new, rr_new] = preconditioner_.apply(residual_, z_);
    direction_.array() = z_.array() + (rz_new / rz) * direction_.array();
    rz = rz_new;
    rr = rr_new;
  }
  return Status::ok;
}

}  // namespace mss
