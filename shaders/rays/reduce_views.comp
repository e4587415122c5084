// Validation errors, one workgroup per view, in an order that is fixed: each invocation sums every 64th ray, then the
// first adds the 64 sums.
#include "effects/appearance/appearance.glsl"
#include "two_float.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_COLOURS) readonly buffer Colours { vec4 colours[]; };
BUFFER(VW_SLOT_VAL_VIEWS) readonly buffer Views { vw_ray_range views[]; };
BUFFER(VW_SLOT_FITS) readonly buffer Fits { vw_appearance fits[]; };
BUFFER(VW_SLOT_SCALARS) writeonly buffer Scalars { vec4 scalars[]; };
PUSH uniform Push { vw_push_reduce push; };

shared vec3 squared_sums[64], absolute_sums[64];

void main() {
    uint view = workgroup_index();
    uint lane = gl_LocalInvocationID.x;
    vw_ray_range range = views[min(view, push.count - 1u)];
    vec3 squared = vec3(0.0), absolute = vec3(0.0);
    for (uint i = lane; i < range.count; i += 64u) {
        vec4 target_weight = rays[range.first + i].target_weight;
        vec3 seen = colours[range.first + i].rgb;
        if (EFFECT_APPEARANCE != 0u || EFFECT_APPEARANCE_CODE != 0u)
            seen = appear(fits[min(view, push.count - 1u)], seen);
        vec3 error = seen - target_weight.rgb;
        if (target_weight.w == 0.0) error = vec3(0.0);
        // Unrolled: some drivers allow an invocation 65,535 trips, which a view of 4 million rays takes as it is.
        [[unroll]] for (int channel = 0; channel < 3; channel++) {
            squared = three_add(squared, vec3(two_square(error[channel]), 0.0));
            absolute = three_add(absolute, vec3(abs(error[channel]), 0.0, 0.0));
        }
    }
    squared_sums[lane] = squared;
    absolute_sums[lane] = absolute;
    barrier();
    if (lane != 0u || view >= push.count) return;
    for (uint i = 1u; i < 64u; i++) {
        squared = three_add(squared, squared_sums[i]);
        absolute = three_add(absolute, absolute_sums[i]);
    }
    scalars[push.scalar_row + 1u + view] = vec4(squared.xy, absolute.xy);
}
