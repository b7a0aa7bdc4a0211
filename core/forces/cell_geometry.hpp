#pragma once

#include <array>

#include "core/base/field.hpp"

namespace mss {

/// Volume of the trilinear hexahedron with corners c = bx + 2 by + 4 bz [m^3]; exact for curved faces.
double trilinear_volume(const std::array<Vec3, 8>& corners);

/// The thesis's estimate of the same, eq. 3-5 and 3-6: one-point quadrature.
double thesis_volume(const std::array<Vec3, 8>& corners);

/// Which side of a cell a corner is on along each axis: -1 or 1.
Vec3 corner_sides(int corner);

/// A cell's mean edges F = [X Y Z], whose volume det F is the thesis's, eq. 3-5 and 3-6.
Eigen::Matrix3d mean_edges(const std::array<Vec3, 8>& corners);
/// det F.
double volume_of(const Eigen::Matrix3d& mean_edges);
/// The volume's derivatives by F: [Y x Z, Z x X, X x Y]; those by a corner are a quarter of their sum, each
/// times the corner's side.
Eigen::Matrix3d volume_slopes(const Eigen::Matrix3d& mean_edges);

/// Signed volume spanned by the three edges at a corner [m^3]; h^3 at rest, negative where the cell is
/// inverted.
double corner_volume(const std::array<Vec3, 8>& corners, int corner);

}  // namespace mss
