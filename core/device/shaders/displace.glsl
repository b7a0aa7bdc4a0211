// The beginning of a step whose unknowns are displacements u = x - x_n: where particles would be without
// springs, dt v + dt^2 a. What is held goes where it belongs at the end of the step. For vertex block descent
// that is its target, and u its first guess, see VbdSolver::guess() in integrators/position_based/.

CONST_FIELD(0, Velocities, v)
FIELD(3, Displacements, u)
#ifdef OUTER
CONST_FIELD(1, Loads, load)
#endif
CONST_FIELD(2, Positions, x)
#ifdef HOLDS_MOVE
CONST_FIELD(4, PositionsAtEnd, x_end)
#endif
#ifdef GUESS
FIELD(5, Targets, target)
FIELD(6, Drifts, drift_before)
uniform int has_step_before;
#ifdef PLANES
layout(std430, binding = 7) restrict readonly buffer Meetings { uint any_pushed; };
#endif
#endif
uniform real step_size;
uniform real gravity_x, gravity_y, gravity_z;

#ifdef GUESS
/// What the step before was changed by, cut: `pull` is dt^2 g.
rvec3 guessed_change(rvec3 change, rvec3 pull) {
  real most = length(pull);
  rvec3 down = most > real(0) ? pull / most : rvec3(0);
  real along = dot(down, change);
  rvec3 guess = clamp(along, real(0), most) * down;
#ifdef PLANES
  rvec3 across = change - along * down;
  real size = length(across);
  if (size > most) across *= most / size;
  if (any_pushed != 0u) guess += across;
#endif
  return guess;
}
#endif

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  int row = coefficients_of(kind_of[i]);
  real dt = step_size;
  rvec3 free = free_axes(row), gravity = rvec3(gravity_x, gravity_y, gravity_z), a = free * gravity;
#ifdef OUTER
  a += inverse_mass(row) * AT(load, i);
#endif
#ifdef TETHERED
  if (i == tether_site) a += inverse_mass(row) * tether_force(AT(x, i), AT(v, i));
#endif
  rvec3 drift = dt * AT(v, i), end = drift + (dt * dt) * a;
#ifdef GUESS
  SET(target, i, end)
  rvec3 pull = (dt * dt) * gravity;
  end = drift + free * (has_step_before != 0 ? guessed_change(drift - AT(drift_before, i), pull) : pull);
  SET(drift_before, i, drift)
#endif
#ifdef HOLDS_MOVE
  rvec3 held = AT(x_end, i) - AT(x, i);
  for (int axis = 0; axis < 3; ++axis)
    if (free[axis] == real(0)) end[axis] = held[axis];
#endif
  SET(u, i, end)
}
