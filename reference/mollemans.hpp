#pragma once

#include <memory>
#include <vector>

#include "core/springs/body_tangents.hpp"
#include "core/springs/spring_system.hpp"
#include "reference/cell_sum.hpp"

namespace mss {

/// Springs with the volume force of Mollemans et al. (2003), eq. 1-1 with the sign that restores: a vertex j
/// of a tetrahedron of volume V is pushed by
///   F_j = -kappa (V - V0) u_j,   u_j = (p_j - b) / |p_j - b|,   b the tetrahedron's barycentre.
/// Tetrahedra: the two ways to cut a cell into five, half of each, so that no direction is preferred.
///
/// kappa is such that an evenly stretched cell has the pressure k_vol (V - V0) / V0 that eq. 3-7
/// gives it. The force is the gradient of no energy, and where a tetrahedron is not regular the u_j do not
/// add up to zero: momentum is conserved only as far as neighbouring cells are deformed alike.
class MollemansSystem final : public BodySystem<double> {
 public:
  /// The body must outlive the system; its springs.volume is k_vol.
  MollemansSystem(const Body& body, const Environment& environment, int threads = 0);

  /// Of the springs: the volume force has no energy.
  StoredEnergy stored_energy(const Field<double>& x) const override { return springs_.stored_energy(x); }
  /// About the middles of cells: the volume force's corner forces do not add up to zero.
  std::optional<std::vector<Eigen::Matrix3d>> cell_virials(const Field<double>& x,
                                                           const Field<double>& v) const override;
  const char* kernel_name() const override { return springs_.kernel_name(); }

  void force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) override;
  Tangents<double>* tangents() override { return &tangents_; }

  /// The factor of the volume force in eq. 1-2, F_j = F_int + F_ext + alpha F_vol, for one of the two ways to
  /// cut cells [N/m^3].
  double alpha() const { return 2 * kappa_; }

 private:
  /// The matrix of the force is unsymmetric. `elastic` and `projected` stand for the symmetric, positive
  /// semidefinite one that pushes along the gradient of each tetrahedron's volume instead of along u.
  class MollemansTangents final : public BodyTangents<double> {
   public:
    explicit MollemansTangents(MollemansSystem& system) : BodyTangents<double>(system), system_(system) {}

   private:
    void add(double t, const Field<double>& x, const Field<double>& v, const TangentCoefficients& sum,
             BlockMatrix& blocks) override;
    void add_diagonal(double t, const Field<double>& x, const Field<double>& v,
                      const TangentCoefficients& sum, std::vector<Eigen::Matrix3d>& diagonal) override;
    void multiply(double t, const Field<double>& x, const Field<double>& v, const TangentCoefficients& sum,
                  const Field<double>& p, Field<double>& out) override;
    CellMatrix cell(const Field<double>& x, std::ptrdiff_t site, const TangentCoefficients& sum) const;

    MollemansSystem& system_;
  };

  CellCorners cell_force(const CellCorners& x) const;

  double kappa_;                  ///< half of it, for either way to cut a cell [N/m^3]
  Body bare_;                     ///< the body without the volume force of eq. 3-7
  SpringSystem<double> springs_;  ///< without planes
  CellSum cells_;
  MollemansTangents tangents_;
};

}  // namespace mss
