#pragma once

#include <Eigen/Core>

#include "core/base/record.hpp"
#include "integrators/reduction/rest_body.hpp"
#include "integrators/reduction/shape_panels.hpp"

namespace mss {

/// Shapes U that a reduced body is a sum of: displacements of particles (ParticleRows by columns) that are
/// orthonormal in the masses and vibrations of the subspace they span, U^T M U = I, U^T K U diagonal.
struct ReducedShapes {
  Eigen::MatrixXd shapes;   ///< 3 particles x r [kg^-1/2]
  Eigen::VectorXd squares;  ///< omega^2 of each [1/s^2], ascending
  Eigen::VectorXd damping;  ///< U^T C U, its diagonal [1/s]

  Eigen::Index count() const { return squares.size(); }
  void remember(Record& record);
};

/// The body's slowest vibrations, and for each load, and the particles that come nearest to each penalty
/// plane, the shape in which the body answers a force there (attachment modes).
ReducedShapes modal_shapes(RestBody& body, const Environment& environment, int modes);

/// Some of the slowest vibrations and the second-order answers to pairs of the first of them (modal
/// derivatives; Barbic and James, ACM TOG 24 (2005) 982), `count` together: of 16 six vibrations and all ten
/// pairs of the first four. Damping is that of the first vibration, in proportion to omega^2.
ReducedShapes derivative_shapes(RestBody& body, int count);

/// Of a free body: what the six centrifugal loads do to it, what the inertia of that does, and so on (Krylov
/// vectors of loads), `count` rounded up to a multiple of six.
ReducedShapes centrifugal_shapes(RestBody& body, int count);

/// Any displacements, by columns as ParticleRows has them, made orthonormal as above; those that depend on
/// others are left out.
ReducedShapes shapes_of(RestBody& body, const Eigen::MatrixXd& displacements);

}  // namespace mss
