#pragma once

#include <memory>
#include <vector>

#include "core/body_system.hpp"
#include "core/spring_system.hpp"
#include "reference/cell_sum.hpp"

namespace mss {

/// Springs with the volume force of Mollemans et al. (2003), eq. 1-1 with the sign that restores: a vertex j
/// of a tetrahedron of volume V is pushed by
///   F_j = -kappa (V - V0) u_j,   u_j = (p_j - b) / |p_j - b|,   b the tetrahedron's barycentre.
/// Tetrahedra: the two ways to cut a cell into five, half of each, so that no direction is preferred.
///
/// kappa is such that a cell which is stretched evenly feels the pressure k_vol (V - V0) / V0 that eq. 3-7
/// gives it. The force is the gradient of no energy, and where a tetrahedron is not regular the u_j do not
/// add up to zero: momentum is kept only as far as cells are deformed alike.
class MollemansSystem final : public BodySystem<double> {
 public:
  /// The body must outlive the system; its springs.volume is k_vol.
  MollemansSystem(const Body& body, const Environment& environment, int threads = 0);

  /// Of the springs: the volume force has no energy.
  StoredEnergy stored_energy(const Field<double>& x) const override { return springs_.stored_energy(x); }
  SpectralBound body_bound() const override;
  const char* kernel_name() const override { return springs_.kernel_name(); }

  void force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) override;
  void tangent_product(double t, const Field<double>& x, const Field<double>& v, const TangentSum& sum,
                       const Field<double>& p, Field<double>& out) override;

 protected:
  /// The matrix of the force is unsymmetric. `elastic` and `projected` hold the symmetric, positive
  /// semidefinite one that pushes along the gradient of each tetrahedron's volume instead of along u.
  void add_tangent(const Field<double>& x, const Field<double>& v, const TangentSum& sum,
                   BlockMatrix& blocks) const override;
  void add_tangent_diagonal(const Field<double>& x, const Field<double>& v, const TangentSum& sum,
                            const BlockMatrix& blocks, std::vector<Eigen::Matrix3d>& diagonal) const override;

 private:
  using Element = CellMatrix;

  CellCorners cell_force(const CellCorners& x) const;
  Element cell_tangent(const CellCorners& x, Tangent kind) const;

  Body bare_;                     ///< the body without the volume force of eq. 3-7
  SpringSystem<double> springs_;  ///< without planes
  CellSum cells_;
  double kappa_;  ///< half of it, for either way to cut a cell [N/m^3]
};

}  // namespace mss
