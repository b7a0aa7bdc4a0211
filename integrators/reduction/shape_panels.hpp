#pragma once

#include <Eigen/Core>
#include <type_traits>
#include <vector>

#include "core/springs/solid_system.hpp"
#include "integrators/reduction/reduction_kernels.hpp"

namespace mss {

/// A matrix with more rows than columns, kept so that its products run at the speed of memory.
template <class Real>
class ShapePanelsIn {
 public:
  using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

  ShapePanelsIn() = default;
  explicit ShapePanelsIn(const Eigen::MatrixXd& matrix);
  ShapePanelsIn(ShapePanelsIn&&) noexcept = default;
  ShapePanelsIn& operator=(ShapePanelsIn&&) noexcept = default;

  /// Rows, and those that pad them: the length of vectors below.
  Eigen::Index padded_rows() const { return panels_.panels * panel_rows; }

  /// out = base + A q
  void expand(const Vector& base, const Vector& q, Vector& out) const {
    if constexpr (std::is_same_v<Real, float>)
      kernels_->expand_single(panels_, base.data(), q.data(), out.data());
    else
      kernels_->expand(panels_, base.data(), q.data(), out.data());
  }
  /// p = A^T f
  void project(const Vector& f, Vector& p) const requires(std::is_same_v<Real, double>) {
    kernels_->project(panels_, f.data(), p.data());
  }

 private:
  AlignedArray<Real> values_;
  Panels<Real> panels_;
  const ReductionKernels* kernels_ = &fastest_copy<ReductionKernels>();
};
using ShapePanels = ShapePanelsIn<double>;

/// The coordinates of a system's particles as one vector: all x, then all y, then all z, by particle.
class ParticleRows {
 public:
  explicit ParticleRows(const System<double>& system);

  Eigen::Index count() const { return 3 * particles_; }
  /// Of a vector of `padded` rows, what is behind count() is 0.
  Eigen::VectorXd from(const Field<double>& field, Eigen::Index padded) const;
  void read(const Field<double>& field, Eigen::VectorXd& rows) const;
  void write(const Eigen::VectorXd& rows, Field<double>& field) const;
  /// field = base + rows, base as rows.
  void write_sum(const Eigen::VectorXd& base, const Eigen::VectorXf& rows, Field<double>& field) const;
  /// The field at every particle is turn rows + offset.
  void write_turned(const Eigen::Matrix3d& turn, const Eigen::VectorXf& rows, const Vec3& offset,
                    Field<double>& field) const;

 private:
  /// Particles at consecutive sites.
  struct Run {
    std::ptrdiff_t site;
    Eigen::Index particle, count;
  };
  Eigen::Index particles_;
  std::vector<Run> runs_;
};

}  // namespace mss
