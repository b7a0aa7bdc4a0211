// What is around a site: the 27 sites of springs and cells that touch it, and the gradient of a cell.

uniform int lattice_row, lattice_plane;
uniform real edge_length, face_length, body_length;  // at rest
uniform real rest_volume;

/// Number of the site one further by dx, dy, dz of the 27 around one, and where it is.
#define AROUND(dx, dy, dz) (((dx) + 1) + 3 * ((dy) + 1) + 9 * ((dz) + 1))
#define OFFSET(dx, dy, dz) ((dx) + lattice_row * (dy) + lattice_plane * (dz))

/// Of a cell to its corner 0, over the sign that the corner has: eq. 3-7. Edges are four times too long, so
/// the volume is 64 times too large.
struct CellSlopes {
  rvec3 x, y, z;
  real volume;
};
CellSlopes cell_slopes(rvec3 a, rvec3 b, rvec3 c, rvec3 d) {
  rvec3 x = mean_edge_x(a, b, c, d), y = mean_edge_y(a, b, c, d), z = mean_edge_z(a, b, c, d);
  CellSlopes by;
  by.x = slope_by_edge(y, z);
  by.y = slope_by_edge(z, x);
  by.z = slope_by_edge(x, y);
  by.volume = real(1.0 / 64.0) * dot(x, by.x);
  return by;
}
rvec3 slope_at(int corner, CellSlopes by) {
  int lower = corner < 4 ? corner : 7 - corner;
  rvec3 slope = lower == 0   ? at_corner_0(by.x, by.y, by.z)
                : lower == 1 ? at_corner_1(by.x, by.y, by.z)
                : lower == 2 ? at_corner_2(by.x, by.y, by.z)
                             : at_corner_3(by.x, by.y, by.z);
  return corner < 4 ? slope : -slope;
}
