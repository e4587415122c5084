// A peak: memory read and written in order, a vec4 per invocation.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_PEAK_FROM) readonly buffer From { vec4 from[]; };
BUFFER(VW_SLOT_PEAK_TO) writeonly buffer To { vec4 to[]; };

void main() {
    uint index = invocation_index();
    to[index] = from[index];
}
