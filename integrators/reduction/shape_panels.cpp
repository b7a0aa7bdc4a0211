#include "integrators/reduction/shape_panels.hpp"

#include <algorithm>

namespace mss {

template <class Real>
ShapePanelsIn<Real>::ShapePanelsIn(const Eigen::MatrixXd& matrix) {
  panels_.columns = int(matrix.cols());
  panels_.panels = (matrix.rows() + panel_rows - 1) / panel_rows;
  values_ = AlignedArray<Real>(std::max<std::ptrdiff_t>(1, panels_.panels * panel_rows * matrix.cols()));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index c = 0; c < matrix.cols(); ++c)
      values_[((i / panel_rows) * matrix.cols() + c) * panel_rows + i % panel_rows] = Real(matrix(i, c));
  panels_.values = values_.data();
}

template class ShapePanelsIn<float>;
template class ShapePanelsIn<double>;

ParticleRows::ParticleRows(const System<double>& system)
    : particles_(Eigen::Index(system.particles().size())) {
  Eigen::Index particle = 0;
  for (const std::ptrdiff_t site : system.particles()) {
    if (runs_.empty() || runs_.back().site + runs_.back().count != site)
      runs_.push_back({.site = site, .particle = particle, .count = 0});
    ++runs_.back().count;
    ++particle;
  }
}

Eigen::VectorXd ParticleRows::from(const Field<double>& field, Eigen::Index padded) const {
  Eigen::VectorXd rows = Eigen::VectorXd::Zero(padded);
  read(field, rows);
  return rows;
}

void ParticleRows::read(const Field<double>& field, Eigen::VectorXd& rows) const {
  for (int axis = 0; axis < 3; ++axis)
    for (const auto& [site, particle, count] : runs_)
      std::copy_n(field.axis(axis) + site, count, rows.data() + axis * particles_ + particle);
}

void ParticleRows::write(const Eigen::VectorXd& rows, Field<double>& field) const {
  for (int axis = 0; axis < 3; ++axis)
    for (const auto& [site, particle, count] : runs_)
      std::copy_n(rows.data() + axis * particles_ + particle, count, field.axis(axis) + site);
}

void ParticleRows::write_sum(const Eigen::VectorXd& base, const Eigen::VectorXf& rows,
                             Field<double>& field) const {
  for (int axis = 0; axis < 3; ++axis)
    for (const auto& [site, particle, count] : runs_) {
      const double* from = base.data() + axis * particles_ + particle;
      const float* by = rows.data() + axis * particles_ + particle;
      double* to = field.axis(axis) + site;
      for (Eigen::Index i = 0; i < count; ++i) to[i] = from[i] + double(by[i]);
    }
}

void ParticleRows::write_turned(const Eigen::Matrix3d& turn, const Eigen::VectorXf& rows, const Vec3& offset,
                                Field<double>& field) const {
  for (int axis = 0; axis < 3; ++axis) {
    const double a = turn(axis, 0), b = turn(axis, 1), c = turn(axis, 2), d = offset[axis];
    for (const auto& [site, particle, count] : runs_) {
      const float *x = rows.data() + particle, *y = x + particles_, *z = y + particles_;
      double* to = field.axis(axis) + site;
      for (Eigen::Index i = 0; i < count; ++i)
        to[i] = a * double(x[i]) + b * double(y[i]) + c * double(z[i]) + d;
    }
  }
}

}  // namespace mss
