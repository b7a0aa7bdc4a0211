// Whether all positions and velocities of particles are finite: else the flag is set.

CONST_FIELD(0, Positions, x)
CONST_FIELD(1, Velocities, v)
layout(std430, binding = 3) buffer Flag { uint flag; };

// By exponents, because shaders need not know what is infinite or not a number.
bool is_finite(float a) { return (floatBitsToUint(a) & 0x7f800000u) != 0x7f800000u; }
bool is_finite(double a) { return (unpackDouble2x32(a).y & 0x7ff00000u) != 0x7ff00000u; }
bool are_finite(rvec3 a) { return is_finite(a.x) && is_finite(a.y) && is_finite(a.z); }

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  if (!are_finite(AT(x, i)) || !are_finite(AT(v, i))) flag = 1u;
}
