// Accelerations; with planes, those of particles that stick to one are 0, and what holds them is kept.

FIELD(3, Accelerations, a)
#ifdef PLANES
layout(std430, binding = 7) restrict buffer Held { double held_force[]; };  // by axis and site
layout(std430, binding = 8) restrict buffer HeldBy { uint held_by[]; };     // plane, from 1
#endif
#ifdef ONLY_IF_COLLIDED
layout(std430, binding = 12) restrict readonly buffer Flag { uint any_collided; };
#endif

#ifdef PLANES
/// sticks() of core/environment/contact.cpp, of a particle whose velocity is 0.
bool sticks(Plane plane, dvec3 at, dvec3 acceleration) {
  if (abs(gap(plane, at)) > 1e-6lf * cell_size) return false;
  double lift = dot(plane.normal, acceleration);
  return lift < 0.0lf && length(acceleration - lift * plane.normal) <= -plane.friction * lift;
}

rvec3 stop_sticking(int i, int row, rvec3 acceleration) {
  uint by = 0u;
  if (AT(v, i) == rvec3(0))
    for (int p = plane_count - 1; p >= 0; --p)
      if (sticks(plane_number(p), dvec3(AT(x, i)), dvec3(acceleration))) by = uint(p) + 1u;
  held_by[i] = by;
  if (by == 0u) return acceleration;
  dvec3 held = -double(mass(row)) * dvec3(acceleration);
  for (int axis = 0; axis < 3; ++axis) held_force[axis * stride + i] = held[axis];
  return rvec3(0);
}
#endif

void main() {
  int i = thread();
#ifdef ONLY_IF_COLLIDED
  if (any_collided == 0u) return;
#endif
  if (i >= thread_count || kind_of[i] == 0u) return;
  int row = coefficients_of(kind_of[i]);
  rvec3 acceleration = acceleration_of(i, row);
#ifdef PLANES
  acceleration = stop_sticking(i, row, acceleration);
#endif
  SET(a, i, acceleration)
}
