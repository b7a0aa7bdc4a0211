#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/springs/block_matrix.hpp"

namespace mss {

/// Derivatives of the force of a spring on its first end, F = [T(|d|) + c (w.u)] u, with u =
/// d/|d|, by the differences d of positions and w of velocities of its ends. Eq. 2-3, 2-5.
struct SpringTangent {
  Eigen::Matrix3d stiffness;  ///< dF/dd [N/m]
  Eigen::Matrix3d damping;    ///< dF/dw [kg/s]
};
SpringTangent spring_tangent(double k, double c, double rest_length, const Vec3& d, const Vec3& w,
                             Tangent kind);

/// Second derivatives of the volume energy k_vol (V - V0)^2 / (2 V0) of eq. 3-5 and 3-6 by a cell's corners.
/// With s_c the corner's sides (+-1) and F = [X Y Z] the mean edges,
///   g_c = dV/dx_c = F^-T s_c det F / 4,   H_cc' = d^2V/dx_c dx_c' = -[F (s_c x s_c')]x / 16,
///   K_cc' = k_vol / V0 (g_c g_c'^T + (V - V0) H_cc').
/// H's eigenvalues come in pairs +-, so the projected form omits it, and a negative k_vol too.
class CellTangent {
 public:
  CellTangent(double k_vol, double rest_volume, const std::array<Vec3, 8>& corners, Tangent kind);
  Eigen::Matrix3d block(int c, int d) const;

 private:
  double stiffness_;  ///< k_vol / V0, of the first term
  double pressure_;   ///< k_vol (V - V0) / V0, of the second
  Eigen::Matrix3d mean_edges_;
  std::array<Vec3, 8> gradient_;
};

/// Calls add(site, corner, other corner, block) for every pair of corners of the cell at a site that a spring
/// of the site, or the cell, joins.
using AddBlock = std::function<void(std::ptrdiff_t site, int c, int d, const Eigen::Matrix3d& block)>;
template <class Real>
void for_each_tangent_block(const Body& body, std::ptrdiff_t site, const Field<Real>& x, const Field<Real>& v,
                            const TangentCoefficients& sum, const AddBlock& add);

/// Adds the tangent of a body's springs and cells, without its masses.
template <class Real>
void add_tangent(const Body& body, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                 BlockMatrix& blocks);

}  // namespace mss
