#pragma once

#include <filesystem>

#include "core/mesh/triangle_mesh.hpp"

namespace mss {

/// A sphere about the origin of 20 n^2 triangles: an icosahedron whose faces are divided n times along each
/// edge, with all vertices at `radius` [m].
TriangleMesh icosphere(double radius, int divisions);

/// A torus about the z axis: the circle of radius `tube` around (ring, 0, 0), turned [m]. 2 x around x across
/// triangles.
TriangleMesh torus(double ring, double tube, int around, int across);

/// An axis-aligned box of twelve triangles.
TriangleMesh box_mesh(const Vec3& lower, const Vec3& upper);

/// A cylinder about the z axis with its middle at the origin and its round side of `around` rectangles.
TriangleMesh cylinder_mesh(double radius, double length, int around);

/// Both in one mesh.
TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b);

/// The same surface, inside out.
TriangleMesh turned_inside_out(TriangleMesh mesh);

/// Writes a Wavefront OBJ file; throws InputError if that fails.
void write_obj(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace mss
