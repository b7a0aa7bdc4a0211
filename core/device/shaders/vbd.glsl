// The particles of one colour, each moved by one thread to the minimum of its quadratic model; see
// integrators/position_based/vbd_kernel.hpp for the formulas. No two of a colour are neighbours.

CONST_FIELD(0, Positions, x)
CONST_FIELD(1, Targets, target)
layout(std430, binding = 2) restrict readonly buffer Particles { uint particles[]; };
FIELD(3, Displacements, u)
uniform int first_particle;
uniform real step_size;

/// Minus the gradient of the objective, and its Hessian, a part of which is a multiple of the identity.
rvec3 force;
real isotropic, xx, yy, zz, yz, zx, xy;

void add_to_hessian(real scale, rvec3 d) {
  rvec3 s = scale * d;
  xx += s.x * d.x;
  yy += s.y * d.y;
  zz += s.z * d.z;
  yz += s.y * d.z;
  zx += s.z * d.x;
  xy += s.x * d.y;
}

/// To a particle `d` away that the step has moved by `w` more than this one.
void add_spring(int n, rvec3 d, rvec3 w, real rest_length, int row) {
  real r = inversesqrt(dot(d, d) + real(1e-30)), k = coefficients[row + n], ratio = rest_length * r;
  real pull = tension_over_length(k, ratio), across = max(pull, real(0));
  real along = spring_stiffness(k, ratio) - across;
#ifdef DAMPED
  real damping = coefficients[row + 27 + n] / step_size;
  pull += damping * (dot(d, w) * (r * r));
  along += damping;
#endif
  force += pull * d;
  isotropic += across;
  add_to_hessian(along * (r * r), d);
}

#ifdef DAMPED
#define MOVED(dx, dy, dz) (AT(u, i + OFFSET(dx, dy, dz)) - moved)
#else
#define MOVED(dx, dy, dz) rvec3(0)
#endif
#define TAKE(dx, dy, dz) \
  SITE(dx, dy, dz) = AT(x, i + OFFSET(dx, dy, dz)) + AT(u, i + OFFSET(dx, dy, dz));
#define SPRING(dx, dy, dz, length) \
  add_spring(AROUND(dx, dy, dz), SITE(dx, dy, dz) - SITE(0, 0, 0), MOVED(dx, dy, dz), length, row);
#define CELL(ox, oy, oz) \
  { \
    const int own = ox + 2 * oy + 4 * oz; \
    CellSlopes by = SLOPES_OF_CELL(ox, oy, oz); \
    real stiffness = coefficients[row + VOLUMES + own]; \
    rvec3 slope = slope_at(own, by); \
    force += (stiffness * (by.volume - rest_volume)) * slope; \
    add_to_hessian(real(1.0 / 64.0) * stiffness, slope); \
  }

void add_neighbours(int i, rvec3 moved, int row) {
  rvec3 at[27];
  TAKE_SITES
  ADD_SPRINGS
  ADD_CELLS
}

/// Held axes do not move, and the others as if they were alone.
void hold(rvec3 free) {
  force *= free;
  xx = free.x > real(0) ? xx + isotropic : real(1);
  yy = free.y > real(0) ? yy + isotropic : real(1);
  zz = free.z > real(0) ? zz + isotropic : real(1);
  xy *= free.x * free.y;
  yz *= free.y * free.z;
  zx *= free.z * free.x;
}

/// Symmetric::solve() of core/kernels/cell_vectors.hpp, of the force.
rvec3 solve() {
  real unit = real(1) / xx, y = unit * yy, z = unit * zz, p = unit * yz, q = unit * zx, r = unit * xy;
  real axx = y * z - p * p, axy = q * p - r * z, azx = r * p - q * y, ayy = z - q * q, ayz = r * q - p,
       azz = y - r * r;
  real scale = unit / (axx + (r * axy + q * azx));
  return scale * rvec3(axx * force.x + (axy * force.y + azx * force.z),
                       axy * force.x + (ayy * force.y + ayz * force.z),
                       azx * force.x + (ayz * force.y + azz * force.z));
}

#ifdef PLANES
/// VertexContact::move(), of a particle near a plane.
rvec3 moved_in_contact(int i, rvec3 free, rvec3 moved) {
  VertexModel model;
  model.hessian = dmat3(xx, xy, zx, xy, yy, yz, zx, yz, zz);
  model.force = dvec3(force);
  model.free = dvec3(free);
  model.before = dvec3(AT(x, i));
  model.u = dvec3(moved);
  model.dt = double(step_size);
  double pressures[PLANE_COUNT];
  dvec3 by = move_in_cone(model, pressures);
  keep(i, model.free, reaction(model, by), model.dt, pressures);
  return rvec3(mix(model.u, model.u + by, model.free));
}
#endif

void main() {
  int n = thread();
  if (n >= thread_count) return;
  int i = int(particles[first_particle + n]), row = coefficients_of(kind_of[i]);
  rvec3 moved = AT(u, i);
  isotropic = mass(row) / (step_size * step_size);
  force = isotropic * (AT(target, i) - moved);
  xx = yy = zz = yz = zx = xy = real(0);
  add_neighbours(i, moved, row);
  rvec3 free = free_axes(row);
  hold(free);
  rvec3 end = moved + solve();
#ifdef PLANES
  if (near[i] != 0u) end = moved_in_contact(i, free, moved);
#endif
  SET(u, i, end)
}
