// Computes where each ray's kept samples begin: a prefix sum of their counts by one workgroup, each invocation over a
// run of rays. Also writes how many workgroups the passes over the slots take, and the slots that pad the last one:
// they contain sample 0 and no gradient.
#include "networks/mlp.glsl"
layout(local_size_x = VW_FIELD_GROUP) in;

BUFFER(VW_SLOT_KEPT_BEGINS) buffer KeptBegins { uint kept_begins[]; };
BUFFER(VW_SLOT_KEPT_SAMPLES) writeonly buffer KeptSamples { uint kept_samples[]; };
BUFFER(VW_SLOT_KEPT) writeonly buffer Kept { vw_kept kept; };
BUFFER(VW_SLOT_D_FIELD) writeonly buffer DField { vec4 d_field[]; };
PUSH uniform Push { vw_push_samples push; };

shared uint sums[VW_FIELD_GROUP];

uint divide_up(uint value, uint part) { return (value + part - 1u) / part; }

void write_groups(uint groups) {
    uint slices = groups * (VW_FIELD_GROUP / SLICE_SAMPLES);
    kept.field_groups = uvec3(groups, 1u, 1u);
    kept.weight_groups = uvec3(divide_up(slices * VW_WEIGHT_TILES(ENC4, WIDTH4) * SLICE_PARTS, 64u), 1u, 1u);
    for (uint level = 0u; level < VW_LEVELS_MAX; level++)
        kept.scatter_groups[level] = uvec3(groups * (VW_FIELD_GROUP / 64u), level + 1u, 1u);
    kept.slots = groups * VW_FIELD_GROUP;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint share = divide_up(push.ray_count, VW_FIELD_GROUP);
    uint first = lane * share, end = min(first + share, push.ray_count);
    uint sum = 0u;
    for (uint ray = first; ray < end; ray++) sum += kept_begins[ray];
    sums[lane] = sum;
    barrier();
    uint before = 0u, total = 0u;
    for (uint i = 0u; i < VW_FIELD_GROUP; i++) {
        before += i < lane ? sums[i] : 0u;
        total += sums[i];
    }
    for (uint ray = first; ray < end; ray++) {
        uint count = kept_begins[ray];
        kept_begins[ray] = before;
        before += count;
    }
    uint groups = divide_up(total, VW_FIELD_GROUP);
    if (lane == 0u) {
        kept_begins[push.ray_count] = total;
        write_groups(groups);
    }
    if (total + lane >= groups * VW_FIELD_GROUP) return;
    kept_samples[total + lane] = 0u;
    d_field[total + lane] = vec4(0.0);
}
