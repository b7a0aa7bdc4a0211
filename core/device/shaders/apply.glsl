// The update that kick_drift.glsl makes, from a given acceleration.

FIELD(3, Positions, x)
FIELD(4, Velocities, v)
CONST_FIELD(5, Accelerations, a)
uniform real kick_before, kick_after, drift_old, drift_new;

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  rvec3 v_old = AT(v, i), v_end = (v_old + kick_before * AT(a, i)) + kick_after * AT(a, i);
  SET(v, i, v_end)
  SET(x, i, AT(x, i) + drift_old * v_old + drift_new * v_end)
}
