#pragma once

#include <cstddef>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace mss::studies::contact {

/// Whether a segment goes through a triangle, by signs of volumes; not where it only touches it.
bool goes_through(const Vec3& from, const Vec3& to, const std::array<Vec3, 3>& triangle);

/// Pairs of triangles of a surface one of which an edge of the other goes through, of all that are farther
/// apart than `neighbours` at rest [m]: a body has gone through itself. Every pair is looked at, so that
/// nothing is missed; it knows nothing of how contact finds what touches. Vertices are first moved inwards
/// by `inset` [m], by which what touches may press into each other.
std::size_t crossings(const TriangleMesh& rest, const std::vector<Vec3>& vertices, double neighbours,
                      double inset);

}  // namespace mss::studies::contact
