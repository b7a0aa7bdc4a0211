// What planes give particles near them within a step, see displacement_contact.glsl.

/// Whether a particle is near a plane in this step: 0, it is not; 1; or 2, if a plane pushed it in the step
/// before.
layout(std430, binding = 5) restrict buffer Near { uint near[]; };
/// Of every plane that along its normal and the three along the plane [kg m], by site.
layout(std430, binding = 6) restrict buffer Multipliers { double multipliers[]; };

double normal_of(int p, int i) { return multipliers[4 * p * stride + i]; }
dvec3 tangential_of(int p, int i) {
  int at = (4 * p + 1) * stride + i;
  return dvec3(multipliers[at], multipliers[at + stride], multipliers[at + 2 * stride]);
}
void set_multipliers(int p, int i, double normal, dvec3 tangential) {
  multipliers[4 * p * stride + i] = normal;
  for (int axis = 0; axis < 3; ++axis) multipliers[(4 * p + 1 + axis) * stride + i] = tangential[axis];
}

bool is_pushed(int i) {
  bool any = false;
  for (int p = 0; near[i] != 0u && p < plane_count; ++p) any = any || normal_of(p, i) > 0.0lf;
  return any;
}
