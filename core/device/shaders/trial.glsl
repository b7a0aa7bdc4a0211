// What a device is tried with before it is used.

uniform int thread_count, threads_in_row, factor;
layout(std430, binding = 14) restrict readonly buffer Given { uint given[]; };
layout(std430, binding = 3) restrict buffer Changed { uint changed[]; };

void main() {
  int i = int(gl_GlobalInvocationID.x) + threads_in_row * int(gl_GlobalInvocationID.y);
  if (i < thread_count) changed[i] += uint(factor) * given[i];
}
