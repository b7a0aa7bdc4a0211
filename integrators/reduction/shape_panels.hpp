#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/springs/solid_system.hpp"
#include "integrators/reduction/reduction_kernels.hpp"

namespace mss {

/// A matrix with more rows than columns, kept so that its products run at the speed of memory.
class ShapePanels {
 public:
  ShapePanels() = default;
  explicit ShapePanels(const Eigen::MatrixXd& matrix);
  ShapePanels(ShapePanels&&) = default;
  ShapePanels& operator=(ShapePanels&&) = default;

  int columns() const { return panels_.columns; }
  /// Rows, and those that pad them: the length of vectors below.
  Eigen::Index padded_rows() const { return panels_.panels * panel_rows; }

  /// out = base + A q
  void expand(const Eigen::VectorXd& base, const Eigen::VectorXd& q, Eigen::VectorXd& out) const {
    kernels_->expand(panels_, base.data(), q.data(), out.data());
  }
  /// p = A^T f
  void project(const Eigen::VectorXd& f, Eigen::VectorXd& p) const {
    kernels_->project(panels_, f.data(), p.data());
  }

 private:
  AlignedArray<double> values_;
  Panels panels_;
  const ReductionKernels* kernels_ = &fastest_copy<ReductionKernels>();
};

/// The coordinates of a system's particles as one vector: all x, then all y, then all z, by particle.
class ParticleRows {
 public:
  explicit ParticleRows(const System<double>& system);

  Eigen::Index count() const { return 3 * particles_; }
  /// Of a vector of `padded` rows, what is behind count() is 0.
  Eigen::VectorXd from(const Field<double>& field, Eigen::Index padded) const;
  void read(const Field<double>& field, Eigen::VectorXd& rows) const;
  void write(const Eigen::VectorXd& rows, Field<double>& field) const;

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
