// Positions and values of a drawn surface from those of particles: one thread per vertex.

CONST_FIELD(0, Positions, x)
layout(std430, binding = 2) restrict readonly buffer Sites { int site_of[]; };
layout(std430, binding = 3) restrict readonly buffer Values { float value_of[]; };
layout(std430, binding = 4) restrict readonly buffer Firsts { int first[]; };  // share of each vertex, and the end
layout(std430, binding = 5) restrict readonly buffer Entries { int entry_of[]; };
layout(std430, binding = 6) restrict readonly buffer Weights { float weight_of[]; };
layout(std430, binding = 7) restrict writeonly buffer Vertices { float vertex[]; };

uniform int vertex_stride, value_place;

void main() {
  int i = thread();
  if (i >= thread_count) return;
  rvec3 at = rvec3(0);
  float value = 0.0;
  for (int n = first[i]; n < first[i + 1]; ++n) {
    at += real(weight_of[n]) * AT(x, site_of[entry_of[n]]);
    value += weight_of[n] * value_of[entry_of[n]];
  }
  for (int axis = 0; axis < 3; ++axis) vertex[vertex_stride * i + axis] = float(at[axis]);
  vertex[vertex_stride * i + value_place] = value;
}
