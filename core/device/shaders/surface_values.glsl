// What a drawn surface is coloured by, at the particles that move it, and the largest of it: one thread per particle.
// As stretch_at() in core/measures/particle_measures.cpp, or the speed.

CONST_FIELD(0, Positions, x)
CONST_FIELD(1, Velocities, v)
layout(std430, binding = 2) restrict readonly buffer Sites { int site_of[]; };
layout(std430, binding = 3) restrict writeonly buffer Values { float value_of[]; };
layout(std430, binding = 4) restrict buffer Largest { uint largest; };

real stretch_at(int i) {
  int row = coefficients_of(kind_of[i]);
  real most = real(0);
  for (int n = 0; n < 27; ++n) {
    if (coefficients[row + n] == real(0)) continue;
    ivec3 to = ivec3(n % 3, n / 3 % 3, n / 9) - 1;
    int axes = abs(to.x) + abs(to.y) + abs(to.z);
    real rest = axes == 1 ? edge_length : axes == 2 ? face_length : body_length;
    rvec3 d = AT(x, i + OFFSET(to.x, to.y, to.z)) - AT(x, i);
    most = max(most, abs(length(d) / rest - real(1)));
  }
  return most;
}

void main() {
  int n = thread();
  if (n >= thread_count) return;
#ifdef SPEED
  real found = length(AT(v, site_of[n]));
#else
  real found = stretch_at(site_of[n]);
#endif
  float value = float(min(found, real(1e30)));
  value_of[n] = value;
  atomicMax(largest, floatBitsToUint(value));  // of numbers from 0 on the bits have their order
}
