// One training ray per RAY_LANES invocations: composite its samples, take the loss, and go back to the gradients of the
// samples' rgb and raw density, and of the sky's logit. Gradients are of the sum over rays; the optimiser divides by
// their number. Sky, weights of rays and what appearance is fitted on are in the variant VW_RAY_EFFECTS alone
// (seen.glsl).
#define SEES_BACK
#include "effects/seen.glsl"
#include "rays/composite.glsl"
#include "rays/loss.glsl"
#include "rays/ray_lanes.glsl"
#include "rays/sample_places.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_FIELD) readonly buffer Field { vec4 field[]; };
BUFFER(VW_SLOT_D_FIELD) buffer DField { vec4 d_field[]; };
BUFFER(VW_SLOT_RAY_LOSS) writeonly buffer RayLoss { float ray_loss[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_samples push; };

#ifdef VW_RAY_EFFECTS
#include "effects/ray_weights.glsl"
#endif

void main() {
    uint index = invocation_index() / RAY_LANES;
    bool beyond = index >= push.ray_count;
    if (RAY_LANES == 1u && beyond) return;
    if (beyond) index = push.ray_count - 1u; // such lanes meet the others at barriers
    uint ray_index = push.first_ray + index;
    vw_ray ray = rays[ray_index];
    uint first = index * SAMPLES, begin, end;
    lane_run(beyond ? 0u : SAMPLES, begin, end);

    ray_march forward = ray_march(0.0, vec3(0.0));
    vec4 all;
    if (RAY_LANES > 1u) {
        float tau = 0.0;
        for (uint i = begin; i < end; i++) tau += field[first + i].w * sample_length(ray, first + i, i);
        forward.tau = sum_beside(vec4(tau), false, all).x;
    }
    for (uint i = begin; i < end; i++) {
        d_field[first + i].w = forward.tau; // kept for the backward pass
        march(forward, field[first + i], sample_length(ray, first + i, i));
    }
    vec3 colour = forward.colour, colour_behind = vec3(0.0);
    if (RAY_LANES > 1u) {
        forward.tau = all.x;
        colour_behind = sum_beside(vec4(forward.colour, 0.0), true, all).rgb;
        colour = all.rgb;
    }
    float left = transmittance(forward.tau);
    vec3 backdrop = backdrop_colour(ray, ray_index, push.key);
    vec3 behind = left * backdrop;
    vec3 seen = colour + behind, error = seen - ray.target_weight.rgb;
    vec3 value, slope;
    for (int channel = 0; channel < 3; channel++) loss_channel(error[channel], value[channel], slope[channel]);
    if (LOSS == LOSS_GIVEN) slope = ray.target_weight.rgb;
    float share = ray.target_weight.w / 3.0; // padding and excluded pixels weigh 0
    float loss = share * (value.x + value.y + value.z);
    bool leads = RAY_LANES == 1u || (ray_lane() == 0u && !beyond); // one lane of a ray writes its results
#ifdef VW_RAY_EFFECTS
    if (rays_are_weighed() && LOSS != LOSS_GIVEN) {
        if (leads) loss = weigh_ray(ray_index, loss, ray.target_weight.w, push.key);
        share *= ray_weight(ray_index);
    }
#endif
    if (leads) ray_loss[ray_index] = loss;
    if (leads && !finite(loss)) atomicOr(state.nonfinite, 1u); // the step is not taken

    vec3 d_colour = share * slope;
    if (leads) seen_back(ray_index, seen, 3.0 * share, backdrop, left, d_colour);
    if (RAY_LANES > 1u) behind += colour_behind;
    for (uint i = end; i-- > begin;)
        d_field[first + i] =
            march_back(behind, d_field[first + i].w, field[first + i], sample_length(ray, first + i, i), d_colour);
}
