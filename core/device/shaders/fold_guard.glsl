// The guard against folding, see core/forces/fold_guard.hpp, in double precision always, as on the processor.
// A first run marks the cells that it may act on, which are few; a second one adds what it does to the loads,
// so that the force on all particles need not contain it.

CONST_FIELD(0, Positions, x)
layout(std430, binding = 1) restrict readonly buffer Stiffnesses { real guard_stiffness[]; };  // by cell
uniform int lattice_row, lattice_plane;
uniform double shortest;

dvec3 position(int i) { return dvec3(AT(x, i)); }
int corner(int cell, int c) { return cell + (c & 1) + lattice_row * ((c >> 1) & 1) + lattice_plane * (c >> 2); }

/// The three edges at a corner, each in the direction of its axis.
dmat3 edges_at(int cell, int c) {
  dmat3 edges;
  for (int axis = 0; axis < 3; ++axis)
    edges[axis] = position(corner(cell, c | (1 << axis))) - position(corner(cell, c & ~(1 << axis)));
  return edges;
}

/// GuardedCorner::may_act().
bool may_act(dmat3 edges) {
  double squared = dot(edges[0], edges[0]) + dot(edges[1], edges[1]) + dot(edges[2], edges[2]);
  double volume = dot(edges[0], cross(edges[1], edges[2]));
  double bound = shortest * max(shortest * shortest, 0.5lf * (squared - shortest * shortest));
  return squared <= 1e300lf && volume <= bound;
}

#ifdef MARK
layout(std430, binding = 3) restrict writeonly buffer Marks { uint marks[]; };

void main() {
  int cell = thread();
  if (cell >= thread_count) return;
  bool acts = false;
  if (guard_stiffness[cell] > real(0))
    for (int c = 0; c < 8; ++c) acts = acts || may_act(edges_at(cell, c));
  marks[cell] = acts ? 1u : 0u;
}
#else

CONST_FIELD(2, Loads, load)
FIELD(3, Outer, outer)
layout(std430, binding = 5) restrict readonly buffer Marks { uint marks[]; };

/// Turns columns p and q of a, and of v with them, until they are at right angles.
void turn(int p, int q, inout dmat3 a, inout dmat3 v) {
  double alpha = dot(a[p], a[p]), beta = dot(a[q], a[q]), gamma = dot(a[p], a[q]);
  if (abs(gamma) <= 1e-16lf * sqrt(alpha * beta) || gamma == 0.0lf) return;
  double zeta = (beta - alpha) / (2.0lf * gamma);
  double t = (zeta >= 0.0lf ? 1.0lf : -1.0lf) / (abs(zeta) + sqrt(1.0lf + zeta * zeta));
  double c = 1.0lf / sqrt(1.0lf + t * t), s = c * t;
  dvec3 ap = a[p], vp = v[p];
  a[p] = c * ap - s * a[q];
  a[q] = s * ap + c * a[q];
  v[p] = c * vp - s * v[q];
  v[q] = s * vp + c * v[q];
}

void swap_columns(int p, int q, inout dmat3 a, inout dmat3 v) {
  if (dot(a[p], a[p]) >= dot(a[q], a[q])) return;
  dvec3 ap = a[p], vp = v[p];
  a[p] = a[q];
  v[p] = v[q];
  a[q] = -ap;  // so that v stays a rotation
  v[q] = -vp;
}

dvec3 any_across(dvec3 u) {
  dvec3 axis = abs(u.x) < 0.6lf ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  return normalize(cross(u, axis));
}

/// GuardedCorner::pull(), by Hestenes' one-sided rotations: A = F V has columns at right angles, whose
/// lengths are the principal stretches, the smallest with the sign of det F.
dmat3 pull_of(double stiffness, dmat3 edges) {
  dmat3 a = edges, v = dmat3(1);
  for (int sweep = 0; sweep < 12; ++sweep) {
    turn(0, 1, a, v);
    turn(0, 2, a, v);
    turn(1, 2, a, v);
  }
  swap_columns(0, 1, a, v);
  swap_columns(1, 2, a, v);
  swap_columns(0, 1, a, v);
  dvec3 s = dvec3(length(a[0]), length(a[1]), 0);
  dmat3 u;
  u[0] = s[0] > 0.0lf ? a[0] / s[0] : dvec3(1, 0, 0);
  u[1] = s[1] > 1e-14lf * s[0] ? a[1] / s[1] : any_across(u[0]);
  u[2] = cross(u[0], u[1]);
  s[2] = dot(u[2], a[2]);
  dmat3 pull = dmat3(0);
  for (int i = 0; i < 3; ++i) {
    double push = -stiffness * min(s[i] - shortest, 0.0lf);
    for (int axis = 0; axis < 3; ++axis) pull[axis] += push * v[i][axis] * u[i];
  }
  return pull;
}

/// On corner `own` of a cell, by the guards of the corner and of its three neighbours.
dvec3 guard_force(int cell, int own) {
  dvec3 force = dvec3(0);
  for (int n = 0; n < 4; ++n) {
    int c = n == 3 ? own : own ^ (1 << n);
    dmat3 edges = edges_at(cell, c);
    if (!may_act(edges)) continue;
    dmat3 pull = pull_of(double(guard_stiffness[cell]), edges);
    for (int axis = 0; axis < 3; ++axis)
      if (n == 3 || n == axis) force += ((own >> axis) & 1) == 1 ? pull[axis] : -pull[axis];
  }
  return force;
}

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  dvec3 force = dvec3(AT(load, i));
  for (int own = 0; own < 8; ++own) {
    int cell = 2 * i - corner(i, own);
    if (cell >= 0 && marks[cell] != 0u) force += guard_force(cell, own);
  }
  SET(outer, i, rvec3(force))
}
#endif
