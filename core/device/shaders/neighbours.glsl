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

// A shader that visits all of them has `rvec3 at[27]`, fills it by TAKE(dx, dy, dz), and says what SPRING(dx,
// dy, dz, rest length) and CELL(ox, oy, oz), by the corner that the particle is of the cell, are to do.
#define SITE(dx, dy, dz) at[AROUND(dx, dy, dz)]

#define TAKE_ROW(dy, dz) TAKE(-1, dy, dz) TAKE(0, dy, dz) TAKE(1, dy, dz)
#define TAKE_PLANE(dz) TAKE_ROW(-1, dz) TAKE_ROW(0, dz) TAKE_ROW(1, dz)
#define TAKE_SITES TAKE_PLANE(-1) TAKE_PLANE(0) TAKE_PLANE(1)

#define OUTER_SPRINGS(dz) \
  SPRING(-1, -1, dz, body_length) SPRING(0, -1, dz, face_length) SPRING(1, -1, dz, body_length) \
  SPRING(-1, 0, dz, face_length) SPRING(0, 0, dz, edge_length) SPRING(1, 0, dz, face_length) \
  SPRING(-1, 1, dz, body_length) SPRING(0, 1, dz, face_length) SPRING(1, 1, dz, body_length)
#define LEVEL_SPRINGS \
  SPRING(-1, -1, 0, face_length) SPRING(0, -1, 0, edge_length) SPRING(1, -1, 0, face_length) \
  SPRING(-1, 0, 0, edge_length) SPRING(1, 0, 0, edge_length) \
  SPRING(-1, 1, 0, face_length) SPRING(0, 1, 0, edge_length) SPRING(1, 1, 0, face_length)
#ifdef SPRINGS
#define ADD_SPRINGS OUTER_SPRINGS(-1) LEVEL_SPRINGS OUTER_SPRINGS(1)
#else
#define ADD_SPRINGS
#endif

#ifdef CELLS
#define ADD_CELLS \
  CELL(0, 0, 0) CELL(1, 0, 0) CELL(0, 1, 0) CELL(1, 1, 0) CELL(0, 0, 1) CELL(1, 0, 1) CELL(0, 1, 1) CELL(1, 1, 1)
#else
#define ADD_CELLS
#endif

/// Of the cell whose corner (ox, oy, oz) the particle is, by its four diagonals.
#define CORNER(cx, cy, cz, ox, oy, oz) SITE((cx) - (ox), (cy) - (oy), (cz) - (oz))
#define SLOPES_OF_CELL(ox, oy, oz) \
  cell_slopes(CORNER(1, 1, 1, ox, oy, oz) - CORNER(0, 0, 0, ox, oy, oz), \
              CORNER(0, 1, 1, ox, oy, oz) - CORNER(1, 0, 0, ox, oy, oz), \
              CORNER(1, 0, 1, ox, oy, oz) - CORNER(0, 1, 0, ox, oy, oz), \
              CORNER(0, 0, 1, ox, oy, oz) - CORNER(1, 1, 0, ox, oy, oz))
