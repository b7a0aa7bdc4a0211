// Prescribed positions and velocities: one thread per held site, with what the processor found for it.

FIELD(3, Positions, x)
FIELD(4, Velocities, v)
layout(std430, binding = 5) restrict readonly buffer Sites { int site_of[]; };
layout(std430, binding = 6) restrict readonly buffer Motions { real motion[]; };  // positions, velocities

void main() {
  int n = thread();
  if (n >= thread_count) return;
  int i = site_of[n];
  rvec3 free = free_axes(coefficients_of(kind_of[i]));
  for (int axis = 0; axis < 3; ++axis) {
    if (free[axis] != real(0)) continue;
    x[pad + axis * stride + i] = motion[6 * n + axis];
    v[pad + axis * stride + i] = motion[6 * n + 3 + axis];
  }
}
