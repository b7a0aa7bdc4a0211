// The acceleration of a particle: each thread adds up the springs and cells around one particle, so that no
// two write to the same place and results are the same bits for any size of work groups. The sweep of the
// processor computes each spring once; here it is computed at both of its ends.

CONST_FIELD(0, Positions, x)
CONST_FIELD(1, Velocities, v)
#ifdef OUTER
CONST_FIELD(2, OuterForces, outer)
#endif

uniform real gravity_x, gravity_y, gravity_z;

/// Of a spring to a particle `d` away, which moves by `w` against this one: the coordinates of sites without
/// a particle may be equal, and 0 times infinity must not arise there.
rvec3 spring_force(int n, rvec3 d, rvec3 w, real rest_length, int row) {
  real r = inversesqrt(dot(d, d) + real(1e-30));
  real pull = tension_over_length(coefficients[row + n], rest_length * r);
#ifdef DAMPED
  pull += coefficients[row + 27 + n] * (dot(d, w) * (r * r));
#endif
  return pull * d;
}

#ifdef DAMPED
#define MOTION(dx, dy, dz) (AT(v, i + OFFSET(dx, dy, dz)) - own_velocity)
#else
#define MOTION(dx, dy, dz) rvec3(0)
#endif
#define TAKE(dx, dy, dz) SITE(dx, dy, dz) = AT(x, i + OFFSET(dx, dy, dz)) - own_position;
#define SPRING(dx, dy, dz, length) \
  force += spring_force(AROUND(dx, dy, dz), SITE(dx, dy, dz), MOTION(dx, dy, dz), length, row);
#define CELL(ox, oy, oz) \
  { \
    const int own = ox + 2 * oy + 4 * oz; \
    CellSlopes by = SLOPES_OF_CELL(ox, oy, oz); \
    force += (coefficients[row + VOLUMES + own] * (by.volume - rest_volume)) * slope_at(own, by); \
  }

/// Of springs and cells [N], on the particle at site i.
rvec3 inner_force(int i, int row) {
  rvec3 own_position = AT(x, i), force = rvec3(0);
#ifdef DAMPED
  rvec3 own_velocity = AT(v, i);
#endif
  rvec3 at[27];  // from the particle
  TAKE_SITES
  ADD_SPRINGS
  ADD_CELLS
  return force;
}

/// [m/s^2], 0 along held axes.
rvec3 acceleration_of(int i, int row) {
  rvec3 force = inner_force(i, row);
#ifdef OUTER
  force += AT(outer, i);
#endif
#ifdef TETHERED
  if (i == tether_site) force += tether_force(AT(x, i), AT(v, i));
#endif
  return inverse_mass(row) * force + free_axes(row) * rvec3(gravity_x, gravity_y, gravity_z);
}
