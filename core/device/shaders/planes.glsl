// Planes of the law `impulse`, see core/environment/contact.cpp and plane_contact.hpp, in double precision
// always, as on the processor: functions have the names that they have there.

struct Plane {
  dvec3 point, normal;
  double restitution, friction;
};
layout(std430, binding = 10) restrict readonly buffer Planes { double planes[]; };
/// What planes have given so far [N s], by plane, axis and site.
layout(std430, binding = 11) restrict buffer Impulses { double impulses[]; };
uniform int plane_count;
uniform double cell_size;

Plane plane_number(int p) {
  int at = 8 * p;
  return Plane(dvec3(planes[at], planes[at + 1], planes[at + 2]),
               dvec3(planes[at + 3], planes[at + 4], planes[at + 5]), planes[at + 6], planes[at + 7]);
}
double gap(Plane plane, dvec3 x) { return dot(plane.normal, x - plane.point); }

void give(int p, int i, dvec3 impulse) {
  for (int axis = 0; axis < 3; ++axis) impulses[(3 * p + axis) * stride + i] += impulse[axis];
}
