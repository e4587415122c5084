#version 460
#extension GL_GOOGLE_include_directive : require
// What validation's score gains by the colour of each of its rays: the mean over views of PSNR, or minus the mean absolute error; with
// gain and bias held as they were fitted. Behind reduce_views. Constant factors are left to whoever takes the gradient. One workgroup per
// view.
#include "common.glsl"
#include "appearance.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_COLOURS) readonly buffer Colours { vec4 colours[]; };
BUFFER(VW_SLOT_VAL_VIEWS) readonly buffer Views { vw_ray_range views[]; };
BUFFER(VW_SLOT_FITS) readonly buffer Fits { vw_appearance fits[]; };
BUFFER(VW_SLOT_SCALARS) readonly buffer Scalars { vec4 scalars[]; };
BUFFER(VW_SLOT_GATHERED) buffer Slopes { vw_ray slopes[]; };
PUSH uniform Push { vw_push_slopes push; };

const float DECIBEL = 8.6858896; // 20 / ln 10: PSNR's slope by the root of the squared error
const float SQUARED_FLOOR = 3e-10; // of a pixel, where PSNR is floored at 100 dB

void main() {
    uint view = min(workgroup_index(), push.count - 1u);
    vw_ray_range range = views[view];
    vec4 sums = scalars[push.scalar_row + 1u + view];
    float squared = sums.x + sums.y;
    float by_error = squared > SQUARED_FLOOR * float(range.count) ? -DECIBEL / squared : 0.0;
    for (uint i = gl_LocalInvocationID.x; i < range.count; i += 64u) {
        vec4 target_weight = rays[range.first + i].target_weight;
        vec3 seen = colours[range.first + i].rgb, gain = vec3(1.0);
        if (EFFECT_APPEARANCE != 0u || EFFECT_APPEARANCE_CODE != 0u) {
            seen = appear(fits[view], seen);
            gain += fits[view].gain.rgb;
        }
        vec3 error = seen - target_weight.rgb;
        vec3 slope = push.measure == 0u ? by_error * error : -sign(error);
        slopes[range.first + i].target_weight.rgb = target_weight.w != 0.0 ? gain * slope : vec3(0.0);
    }
}
