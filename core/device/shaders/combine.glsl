// result = base + scale added, which may be the same buffers.

layout(std430, binding = 3) buffer Result { real result[]; };
layout(std430, binding = 4) buffer Base { real base[]; };
layout(std430, binding = 5) buffer Added { real added[]; };
uniform real scale;

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  SET(result, i, AT(base, i) + scale * AT(added, i))
}
