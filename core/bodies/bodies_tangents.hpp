#pragma once

#include <vector>

#include "core/bodies/bodies_system.hpp"

namespace mss {

/// Tangents of several bodies: of each its own, and of contact between them its springs'. What touches what
/// changes from state to state, and with it the entries of the matrix: values() writes those of the moment.
template <class Real>
class BodiesTangents final : public Tangents<Real> {
 public:
  /// The system must outlive it.
  explicit BodiesTangents(BodiesSystem<Real>& system) : system_(system) {}

  const std::vector<FreeDof>& unknowns() override;
  /// While nothing touches.
  SparseMatrix pattern() override;
  bool has_fixed_pattern() const override { return system_.forces_ == nullptr; }
  void values(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
              SparseMatrix& matrix) override;
  void product(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
               const Field<Real>& p, Field<Real>& out) override;
  void diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                std::vector<Eigen::Matrix3d>& blocks) override;

 private:
  void build();
  void load(const Field<Real>& x, const Field<Real>& v);
  std::ptrdiff_t site_of(const ContactForces::Carrier& carrier) const {
    return system_.levels_[std::size_t(carrier.body)].first + carrier.site;
  }

  BodiesSystem<Real>& system_;
  std::vector<FreeDof> unknowns_;
  std::vector<int> number_;            ///< of an unknown, by site and axis; -1: prescribed
  std::vector<SparseMatrix> of_body_;  ///< built at the first use: they are large
  SparseMatrix bodies_;                ///< these, one after the other
};

}  // namespace mss
