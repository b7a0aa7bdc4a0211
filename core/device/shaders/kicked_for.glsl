// What sticks to a plane is held by it while velocities change by the last acceleration.

layout(std430, binding = 7) restrict readonly buffer Held { double held_force[]; };
layout(std430, binding = 8) restrict readonly buffer HeldBy { uint held_by[]; };
uniform double seconds;

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u || held_by[i] == 0u) return;
  give(int(held_by[i]) - 1, i,
       seconds * dvec3(held_force[i], held_force[stride + i], held_force[2 * stride + i]));
}
