#version 460
#extension GL_GOOGLE_include_directive : require
// One training ray per invocation: composite its samples, take the loss, and go back to the gradients of the samples' rgb and raw density.
// Gradients are of the sum over rays; the optimiser divides by their number.
#include "common.glsl"
#include "composite.glsl"
#include "loss.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_FIELD) readonly buffer Field { vec4 field[]; };
BUFFER(VW_SLOT_D_FIELD) buffer DField { vec4 d_field[]; };
BUFFER(VW_SLOT_KEPT_BEGINS) readonly buffer KeptBegins { uint kept_begins[]; };
BUFFER(VW_SLOT_RAY_LOSS) writeonly buffer RayLoss { float ray_loss[]; };
PUSH uniform Push { vw_push_samples push; };

void main() {
    uint index = invocation_index();
    if (index >= push.ray_count) return;
    vw_ray ray = rays[push.first_ray + index];
    float stride = ray.direction_stride.w;
    uint first = index * SAMPLES, count = SAMPLES;
    if (EFFECT_OCCUPANCY != 0u) { // samples that were skipped have no density: they change neither colour nor gradient
        first = kept_begins[index];
        count = kept_begins[index + 1u] - first;
    }

    ray_march forward = ray_march(0.0, vec3(0.0));
    for (uint i = 0u; i < count; i++) {
        d_field[first + i].w = forward.tau; // kept for the way back
        march(forward, field[first + i], stride);
    }
    vec3 behind = transmittance(forward.tau) * background_colour();
    vec3 error = forward.colour + behind - ray.target_weight.rgb;
    vec3 value, slope;
    for (int channel = 0; channel < 3; channel++) loss_channel(error[channel], value[channel], slope[channel]);
    float share = ray.target_weight.w / 3.0; // padding and excluded pixels weigh 0
    ray_loss[push.first_ray + index] = share * (value.x + value.y + value.z);

    vec3 d_colour = share * slope;
    for (uint i = count; i-- > 0u;) d_field[first + i] = march_back(behind, d_field[first + i].w, field[first + i], stride, d_colour);
}
