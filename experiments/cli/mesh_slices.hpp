#pragma once

#include "core/mesh/mesh_fill.hpp"
#include "experiments/plot/map_chart.hpp"

namespace mss::cli {

/// Two upright slices through a mesh and the cells that it fills, one above the x axis and one above the y
/// axis, of one scale: through the largest part that no cell has, or else through the mesh's centre.
MapChart mesh_slices(const TriangleMesh& mesh, const MeshFill& fill);

}  // namespace mss::cli
