// A peak: multiply-adds with operands in registers alone, in eight independent chains of vec4, unrolled. What comes out
// does not matter, but has to go somewhere, or the compiler would drop it all.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_PEAK_TO) writeonly buffer To { vec4 to[]; };
PUSH uniform Push { vw_push_peak push; };

void main() {
    vec4 chain[8];
    [[unroll]] for (uint i = 0u; i < 8u; i++) chain[i] = vec4(float(i) + push.start);
    for (uint trip = 0u; trip < VW_PEAK_TRIPS; trip++) {
        [[unroll]] for (uint turn = 0u; turn < VW_PEAK_REPEATS; turn++) {
            [[unroll]] for (uint i = 0u; i < 8u; i++) chain[i] = chain[i] * push.factor + push.start;
        }
    }
    vec4 sum = vec4(0.0);
    [[unroll]] for (uint i = 0u; i < 8u; i++) sum += chain[i];
    to[invocation_index() % uint(to.length())] = sum; // a test has no room for all
}
