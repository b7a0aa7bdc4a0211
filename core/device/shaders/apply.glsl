// An update from a given acceleration.

FIELD(3, Positions, x)
FIELD(4, Velocities, v)
CONST_FIELD(5, Accelerations, a)

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  rvec3 v_old = AT(v, i), v_end = kicked(v_old, AT(a, i));
  SET(v, i, v_end)
  SET(x, i, drifted(AT(x, i), v_old, v_end))
}
