#pragma once

#include <memory>

#include "core/springs/block_matrix.hpp"
#include "core/springs/body_system.hpp"

namespace mss {

/// Tangents of a body in its environment: its masses and penalty planes, and what a derived class adds for
/// the contents of its cells.
template <class Real>
class BodyTangents : public Tangents<Real> {
 public:
  /// The system must outlive it.
  explicit BodyTangents(BodySystem<Real>& system) : system_(system) {}

  const std::vector<FreeDof>& unknowns() final;
  SparseMatrix pattern() final { return blocks().pattern(); }
  void values(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
              SparseMatrix& matrix) final;
  void product(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
               const Field<Real>& p, Field<Real>& out) final;
  void diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                std::vector<Eigen::Matrix3d>& diagonal) final;

 protected:
  const Body& body() const { return system_.body(); }

  /// Adds the cells' tangent, without masses.
  virtual void add(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                   BlockMatrix& blocks) = 0;
  /// Adds its blocks on the diagonal, one per particle.
  virtual void add_diagonal(double t, const Field<Real>& x, const Field<Real>& v,
                            const TangentCoefficients& sum, std::vector<Eigen::Matrix3d>& diagonal) = 0;
  /// The product of the cells' tangent and of masses with p; overwritten.
  virtual void multiply(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                        const Field<Real>& p, Field<Real>& out) = 0;

 private:
  /// Built at the first use: it is large, and only matrices that are stored need it.
  BlockMatrix& blocks();
  /// All of them in the matrix; their products with p, added to out; their blocks on the diagonal.
  void add_penalties(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                     BlockMatrix& matrix);
  void add_penalties(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                     const Field<Real>& p, Field<Real>& out);
  void add_penalties(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                     std::vector<Eigen::Matrix3d>& diagonal);
  Eigen::Matrix3d penalty_at(double t, std::ptrdiff_t site, const Field<Real>& x, const Field<Real>& v,
                             const TangentCoefficients& sum) const {
    return system_.contact().tangent({x.at(site), v.at(site)}, t, sum, body().mass(site));
  }

  BodySystem<Real>& system_;
  std::vector<FreeDof> unknowns_;
  std::unique_ptr<BlockMatrix> blocks_;
};

}  // namespace mss
