// Whether all positions and velocities of particles are finite: else the flag is set.

CONST_FIELD(0, Positions, x)
CONST_FIELD(1, Velocities, v)
layout(std430, binding = 3) buffer Flag { uint flag; };

/// False for what is infinite or not a number, whose comparisons are false.
bool are_finite(rvec3 a) {
  const real largest = real(3.4e38);
  return abs(a.x) <= largest && abs(a.y) <= largest && abs(a.z) <= largest;
}

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  if (!are_finite(AT(x, i)) || !are_finite(AT(v, i))) flag = 1u;
}
