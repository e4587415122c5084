// The colour seen at every pixel of the tiles, its loss, and the gradients by the blended colour and by what is left of
// the light from beyond. Gradients are of the sum over rays; the optimiser divides by their number. The sky,
// weights of rays, and what fit_photo needs, are in the variant VW_RAY_EFFECTS alone (seen.glsl).
#define SEES_BACK
#include "effects/seen.glsl"
#include "rays/loss.glsl"
#include "splats/constants.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_COLOURS) readonly buffer Colours { vec4 colours[]; };
BUFFER(VW_SLOT_SPLAT_STATE) readonly buffer SplatState { vw_splat_state splat_state; };
BUFFER(VW_SLOT_D_WINDOWS) readonly buffer DWindows { vec4 d_windows[]; };
BUFFER(VW_SLOT_D_COLOURS) writeonly buffer DColours { vec4 d_colours[]; };
BUFFER(VW_SLOT_RAY_LOSS) writeonly buffer RayLoss { float ray_loss[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_splats push; };

#ifdef VW_RAY_EFFECTS
#include "effects/ray_weights.glsl"
#endif

void main() {
    uint index = invocation_index();
    if (index == 0u && splat_state.overflow != 0u) atomicOr(state.nonfinite, 1u); // the step is not taken
    if (index >= d_colours.length()) return;
    vw_ray ray = rays[index];
    bool drawn = index < push.tile_count * SPLAT_SIDE * SPLAT_SIDE;
    vec4 blended = mix(vec4(0.0), colours[index], bvec4(drawn)); // rays that the photo has no tiles for weigh 0
    vec3 backdrop = backdrop_colour(ray, index, push.key);
    vec3 seen = blended.rgb + blended.a * backdrop, error = seen - ray.target_weight.rgb;
    vec3 value, slope;
    for (int channel = 0; channel < 3; channel++) loss_channel(error[channel], value[channel], slope[channel]);
    if (LOSS == LOSS_GIVEN) slope = ray.target_weight.rgb;
    float share = ray.target_weight.w / 3.0; // padding and excluded pixels weigh 0
    float loss = share * (value.x + value.y + value.z);
    vec4 window = vec4(0.0);
    if (SSIM_WEIGHT > 0.0) {
        window = mix(window, d_windows[index], bvec4(drawn));
        loss = mix(loss, window.w, SSIM_WEIGHT);
    }
#ifdef VW_RAY_EFFECTS
    if (rays_are_weighed()) {
        loss = weigh_ray(index, loss, ray.target_weight.w, push.key);
        share *= ray_weight(index);
    }
#endif
    vec3 d_colour = share * slope;
    if (SSIM_WEIGHT > 0.0) d_colour = mix(d_colour, window.rgb, SSIM_WEIGHT);
    ray_loss[index] = loss;
    if (!finite(loss)) atomicOr(state.nonfinite, 1u); // nor here
    seen_back(index, seen, 3.0 * share, backdrop, blended.a, d_colour);
    d_colours[index] = vec4(d_colour, dot(d_colour, backdrop));
}
