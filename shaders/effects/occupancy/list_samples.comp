// The kept samples of a ray in its slots, in order; one ray per invocation.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_KEPT_BITS) readonly buffer KeptBits { uint kept_bits[]; };
BUFFER(VW_SLOT_KEPT_BEGINS) readonly buffer KeptBegins { uint kept_begins[]; };
BUFFER(VW_SLOT_KEPT_SAMPLES) writeonly buffer KeptSamples { uint kept_samples[]; };
PUSH uniform Push { vw_push_samples push; };

void main() {
    uint index = invocation_index();
    if (index >= push.ray_count) return;
    uint slot = kept_begins[index];
    for (uint i = 0u; i < SAMPLES; i++) {
        uint bits = kept_bits[index * VW_KEPT_WORDS(SAMPLES) + i / 32u];
        if ((bits >> (i % 32u) & 1u) != 0u) kept_samples[slot++] = index * SAMPLES + i;
    }
}
