#pragma once

#include <functional>

#include "core/springs/solid_system.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// A body's linear response from its undeformed state.
struct LinearResponse {
  Status status = Status::ok;
  Field<double> displacement;  ///< u [m]
  Field<double> load;          ///< f: gravity and loads [N]
  Field<double> reaction;      ///< K u - f: at prescribed coordinates [N]
};

/// Solves K u = f with CHOLMOD. Held coordinates are displaced by `prescribed` of their rest position, or not
/// at all; the motion of the holds themselves is ignored.
LinearResponse linear_response(SolidSystem<double>& system,
                               const std::function<Vec3(const Vec3& rest)>& prescribed, Work& work);

/// Sum of products of two fields at particles.
double inner(const SolidSystem<double>& system, const Field<double>& a, const Field<double>& b);

}  // namespace mss
