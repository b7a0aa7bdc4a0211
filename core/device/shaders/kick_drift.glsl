// One step of a method with one acceleration, see KickDrift in core/system/system.hpp.

FIELD(3, NewPositions, x_new)
FIELD(4, NewVelocities, v_new)
uniform real kick_before, kick_after, drift_old, drift_new;

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  rvec3 a = acceleration_of(i, coefficients_of(kind_of[i])), v_old = AT(v, i);
  rvec3 v_end = (v_old + kick_before * a) + kick_after * a;
  SET(v_new, i, v_end)
  SET(x_new, i, AT(x, i) + drift_old * v_old + drift_new * v_end)
}
