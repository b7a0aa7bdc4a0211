// Loads into a field of forces: one thread per loaded site.

FIELD(3, Forces, force)
layout(std430, binding = 5) restrict readonly buffer Sites { int site_of[]; };
layout(std430, binding = 6) restrict readonly buffer Loads { real load[]; };

void main() {
  int n = thread();
  if (n >= thread_count) return;
  SET(force, site_of[n], rvec3(load[3 * n], load[3 * n + 1], load[3 * n + 2]))
}
