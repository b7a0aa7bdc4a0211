#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/body/body.hpp"

namespace mss {

/// Appends the virials of a level's cells (SolidSystem::cell_virials()) at positions x [m] and velocities v
/// [m/s] of the whole, of springs and dampers, volume force and guard against folding.
template <class Real>
void append_virials(const Level& level, const Field<Real>& x, const Field<Real>& v,
                    std::vector<Eigen::Matrix3d>& virials);

}  // namespace mss
