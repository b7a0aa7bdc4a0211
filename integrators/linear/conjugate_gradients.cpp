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
    const Eigen::Matrix3d inverse = block.inverse();
    std::size_t entry = 0;
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b) inverse_[entry++][site] = inverse(a, b);
  }
}

void BlockJacobi::apply(const Field<double>& r, Field<double>& z) const {
  static constexpr std::size_t entry[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  const std::ptrdiff_t sites = inverse_.front().size();
  for (int a = 0; a < 3; ++a) {
    const double *m0 = inverse_[entry[a][0]].data(), *m1 = inverse_[entry[a][1]].data(),
                 *m2 = inverse_[entry[a][2]].data();
    for (std::ptrdiff_t i = 0; i < sites; ++i)
      z.axis(a)[i] = m0[i] * r.axis(0)[i] + m1[i] * r.axis(1)[i] + m2[i] * r.axis(2)[i];
  }
  z.array() *= mask_.array();
}

Status ConjugateGradients::prepare(System<double>& system, double t, const Field<double>& x,
                                   const Field<double>& v, const TangentSum& sum, Work& work) {
  if (residual_.size() == 0)
    for (Field<double>* field : {&residual_, &z_, &direction_, &image_})
      *field = Field<double>(system.size());
  most_iterations_ = std::max(100L, long(system.unknowns().size()));
  preconditioner_.prepare(system, t, x, v, sum);
  prepare_product(system, t, x, v, sum, work);
  ++work.jacobians;
  return Status::ok;
}

Status ConjugateGradients::solve(const Field<double>& rhs, Field<double>& solution, Work& work) {
  ++work.linear_solves;
  const auto dot = [](const Field<double>& a, const Field<double>& b) {
    return a.array().matrix().dot(b.array().matrix());
  };
  const auto mask = preconditioner_.mask().array();
  solution.array() = 0;
  residual_.array() = rhs.array() * mask;
  const double target = tolerance_ * tolerance_ * dot(residual_, residual_);
  preconditioner_.apply(residual_, z_);
  direction_ = z_;
  double rz = dot(residual_, z_);
  for (long iteration = 0; iteration < most_iterations_; ++iteration) {
    if (dot(residual_, residual_) <= target) return Status::ok;
    product(direction_, image_);
    ++work.products;
    image_.array() *= mask;
    const double curvature = dot(direction_, image_);
    if (!std::isfinite(curvature)) return Status::non_finite;
    if (curvature <= 0) return Status::not_positive_definite;
    const double step = rz / curvature;
    solution.array() += step * direction_.array();
    residual_.array() -= step * image_.array();
    preconditioner_.apply(residual_, z_);
    const double rz_old = rz;
    rz = dot(residual_, z_);
    direction_.array() = z_.array() + (rz / rz_old) * direction_.array();
  }
  return dot(residual_, residual_) <= target ? Status::ok : Status::linear_stalled;
}

}  // namespace mss
