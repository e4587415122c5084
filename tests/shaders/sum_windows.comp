// high[i] += low[i]: two windows, of the same buffer or of two, with sizes that specialization sets.
#version 460
layout(local_size_x_id = 1) in;

layout(constant_id = 0) const uint SHARED_WORDS = 16;
layout(constant_id = 2) const uint UNUSED = 1;
const uint UNUSED_EITHER = UNUSED + 1;
layout(set = 0, binding = 0) readonly buffer Low { uint low[]; };
layout(set = 0, binding = 1) buffer High { uint high[]; };
shared uint staged[SHARED_WORDS * 4];

void main() {
    uint i = gl_GlobalInvocationID.x;
    staged[gl_LocalInvocationID.x % SHARED_WORDS] = 0;
    barrier();
    if (i < high.length()) high[i] += low[i] + staged[0];
}
