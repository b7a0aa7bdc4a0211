// Zeroes a buffer of 32-bit words.

uniform int thread_count, threads_in_row;
layout(std430, binding = 0) restrict writeonly buffer Words { uint words[]; };

void main() {
  int i = int(gl_GlobalInvocationID.x) + threads_in_row * int(gl_GlobalInvocationID.y);
  if (i < thread_count) words[i] = 0u;
}
