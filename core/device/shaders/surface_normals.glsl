// Normals of a drawn surface, by the areas of faces: one thread per vertex.

layout(std430, binding = 4) restrict readonly buffer Firsts { int first[]; };  // face of each vertex, and the end
layout(std430, binding = 5) restrict readonly buffer FacesAt { int face_of[]; };
layout(std430, binding = 6) restrict readonly buffer Faces { int corner_of[]; };  // four each
layout(std430, binding = 7) restrict buffer Vertices { float vertex[]; };

uniform int vertex_stride, normal_place;

vec3 corner(int face, int n) {
  int at = vertex_stride * corner_of[4 * face + n];
  return vec3(vertex[at], vertex[at + 1], vertex[at + 2]);
}

void main() {
  int i = thread();
  if (i >= thread_count) return;
  vec3 normal = vec3(0);
  for (int n = first[i]; n < first[i + 1]; ++n) {
    int face = face_of[n];
    normal += cross(corner(face, 2) - corner(face, 0), corner(face, 3) - corner(face, 1));
  }
  float size = length(normal);
  if (size > 0.0) normal /= size;
  for (int axis = 0; axis < 3; ++axis) vertex[vertex_stride * i + normal_place + axis] = normal[axis];
}
