// What a device is tried with before it is used.

uniform int thread_count, threads_in_row;
uniform double factor;
layout(std430, binding = 14) restrict readonly buffer Given { float given[]; };
layout(std430, binding = 3) restrict buffer Sums { float sums[]; };

void main() {
  int i = int(gl_GlobalInvocationID.x) + threads_in_row * int(gl_GlobalInvocationID.y);
  if (i < thread_count) sums[i] = float(double(sums[i]) + factor * double(given[i]));
}
