// The end of such a step: x += u, v = u / dt.

CONST_FIELD(0, Displacements, u)
FIELD(3, Positions, x)
FIELD(4, Velocities, v)
uniform real rate;  // 1 / dt

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  rvec3 moved = AT(u, i);
  SET(x, i, AT(x, i) + moved)
  SET(v, i, rate * moved)
}
