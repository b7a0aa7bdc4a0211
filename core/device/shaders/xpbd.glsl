// The cells of one colour, each projected by one thread, in the order of the processor; see
// integrators/position_based/xpbd_kernel.hpp for the formulas. No other cell of the colour has one of its
// corners.

CONST_FIELD(0, Positions, x)
/// Of every cell its site, and the row of its coefficients times 256, plus the corners that it moves, a bit
/// each.
layout(std430, binding = 1) restrict readonly buffer Cells { uvec2 cells[]; };
/// Rows of A, B and G of every spring, then that of the volume.
layout(std430, binding = 2) restrict readonly buffer Constraints { real constraints[]; };
FIELD(3, Displacements, u)
#ifdef KEEP
/// By constraint and cell.
layout(std430, binding = 4) restrict buffer Multipliers { real multipliers[]; };
#endif
uniform int first_cell, cell_count;

/// Of the corners, while they are projected; w: inverse masses by axis.
rvec3 before[8], moved[8], w[8];

void push_apart(int a, int b, rvec3 impulse) {
  moved[a] += w[a] * impulse;
  moved[b] -= w[b] * impulse;
}

void project_spring(int s, int a, int b, real rest_length, int row, int cell) {
  real stiff = constraints[row + 3 * s], damp = constraints[row + 3 * s + 1];
  if (stiff == real(0) && damp == real(0)) return;
  rvec3 du = moved[a] - moved[b], d = (before[a] - before[b]) + du;
  real squared = dot(d, d) + real(1e-30), r = inversesqrt(squared), ratio = rest_length * r;
  real factor = projection_factor(ratio, (w[a].x + w[b].x) * stiff);
  real lambda = (factor * law_secant(strain_of_ratio(ratio))) *
                (stiff * spring_shortening(rest_length, squared, r));
#ifdef DAMPED
  lambda -= factor * (damp * (dot(d, du) * r));
#endif
#ifdef KEEP
  real kept = multipliers[s * cell_count + cell];
  lambda -= factor * (constraints[row + 3 * s + 2] * kept);
  multipliers[s * cell_count + cell] = kept + lambda;
#endif
  push_apart(a, b, (lambda * r) * d);
}

real mobility_of(int corner, rvec3 slope) { return dot(w[corner], slope * slope); }

rvec3 corner_at(int corner) { return before[corner] + moved[corner]; }

/// grad V of a corner is -slope_at() / 64.
void project_volume(int row, int cell) {
  real stiffness = constraints[row + 39];
  if (stiffness == real(0)) return;
  CellSlopes by = cell_slopes(corner_at(7) - corner_at(0), corner_at(6) - corner_at(1),
                              corner_at(5) - corner_at(2), corner_at(4) - corner_at(3));
  real mobility = real(0);
  for (int c = 0; c < 4; ++c) {
    rvec3 slope = slope_at(c, by);
    mobility += mobility_of(c, slope) + mobility_of(7 - c, slope);
  }
  real lambda = stiffness * (rest_volume - by.volume);
#ifdef KEEP
  real kept = multipliers[13 * cell_count + cell];
  lambda -= kept;
#endif
  lambda /= (real(1.0 / 4096.0) * stiffness) * mobility + real(1);
#ifdef KEEP
  multipliers[13 * cell_count + cell] = kept + lambda;
#endif
  for (int c = 0; c < 4; ++c) push_apart(7 - c, c, (real(1.0 / 64.0) * lambda) * slope_at(c, by));
}

void main() {
  int n = thread();
  if (n >= thread_count) return;
  n += first_cell;
  int site = int(cells[n].x), row = int(cells[n].y >> 8) * 40;
  uint moves = cells[n].y & 255u;
  for (int c = 0; c < 8; ++c) {
    before[c] = moved[c] = w[c] = rvec3(0);
    if (((moves >> c) & 1u) == 0u) continue;
    int i = site + OFFSET(c & 1, (c >> 1) & 1, c >> 2);
    before[c] = AT(x, i);
    moved[c] = AT(u, i);
    w[c] = inverse_mass(coefficients_of(kind_of[i]));
  }
  project_volume(row, n);
  project_spring(3, 0, 3, face_length, row, n);
  project_spring(10, 1, 6, body_length, row, n);
  project_spring(11, 2, 5, body_length, row, n);
  project_spring(4, 0, 5, face_length, row, n);
  project_spring(12, 3, 4, body_length, row, n);
  project_spring(5, 0, 6, face_length, row, n);
  project_spring(7, 1, 4, face_length, row, n);
  project_spring(9, 0, 7, body_length, row, n);
  project_spring(0, 0, 1, edge_length, row, n);
  project_spring(8, 2, 4, face_length, row, n);
  project_spring(1, 0, 2, edge_length, row, n);
  project_spring(2, 0, 4, edge_length, row, n);
  project_spring(6, 1, 2, face_length, row, n);
  for (int c = 0; c < 8; ++c)
    if (((moves >> c) & 1u) != 0u) SET(u, site + OFFSET(c & 1, (c >> 1) & 1, c >> 2), moved[c])
}
