// One step of a method with one acceleration.

FIELD(3, NewPositions, x_new)
FIELD(4, NewVelocities, v_new)

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  rvec3 v_old = AT(v, i), v_end = kicked(v_old, acceleration_of(i, coefficients_of(kind_of[i])));
  SET(v_new, i, v_end)
  SET(x_new, i, drifted(AT(x, i), v_old, v_end))
}
