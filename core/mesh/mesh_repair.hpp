#pragma once

#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace mss {

/// Share of a mesh's longest extent within which vertices at open edges become one.
inline constexpr double weld_tolerance = 1e-5;

/// Joins vertices at open edges, those of one triangle alone, that are nearer to each other than
/// weld_tolerance times the longest extent, and drops triangles that vanish by it. Returns how many vertices
/// were joined with another. A mesh that this does not close further stays as it is.
std::size_t weld_seams(TriangleMesh& mesh);

/// Turns triangles that face the other way than those that they share an edge with. Of patches that meet
/// along edges of two triangles, the fewer triangles turn. A patch that cannot face one way, as Moebius's
/// strip, stays as it is. Returns how many were turned.
std::size_t turn_alike(TriangleMesh& mesh);

/// Edges of two triangles that face opposite ways.
std::size_t inconsistent_edges(const TriangleMesh& mesh);

}  // namespace mss
