// backward_rays with the effect transient, one training ray per invocation: composites both densities, takes the loss,
// and goes back to the gradients of the samples' rgb and raw density, of what the transient head gave out, and of the
// sky's logit. The sky, and what fit_photo needs, are in the variant VW_RAY_EFFECTS, as there.
#define SEES_BACK
#include "effects/seen.glsl"
#include "rays/sample_places.glsl"
#include "effects/transient/transient.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_FIELD) readonly buffer Field { vec4 field[]; };
BUFFER(VW_SLOT_D_FIELD) buffer DField { vec4 d_field[]; };
BUFFER(VW_SLOT_LAYER_ROWS) readonly buffer LayerRows { vec4 layer_rows[]; };
BUFFER(VW_SLOT_D_LAYER_ROWS) writeonly buffer DLayerRows { vec4 d_layer_rows[]; };
BUFFER(VW_SLOT_RAY_LOSS) writeonly buffer RayLoss { float ray_loss[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_samples push; };

transient_sample transient_at(uint slot) {
    return activate_transient(layer_rows[VW_ROW_PLACE(LAYER_ROWS, TRANSIENT_ROW, slot)],
                              layer_rows[VW_ROW_PLACE(LAYER_ROWS, TRANSIENT_ROW + 1u, slot)].x);
}

void main() {
    uint index = invocation_index();
    if (index >= push.ray_count) return;
    uint ray_index = push.first_ray + index, first = index * SAMPLES;
    vw_ray ray = rays[ray_index];
    transient_march forward = transient_march(0.0, vec3(0.0), 0.0, 0.0);
    for (uint i = 0u; i < SAMPLES; i++) {
        d_field[first + i].w = forward.tau; // kept for the backward pass
        march_both(forward, field[first + i], transient_at(first + i), sample_length(ray, first + i, i));
    }
    float left = transmittance(forward.tau);
    vec3 backdrop = backdrop_colour(ray, ray_index, push.key);
    vec3 seen = forward.colour + left * backdrop;
    transient_slopes slopes;
    float weight = ray.target_weight.w; // padding and excluded pixels weigh 0
    float loss = weight * transient_loss(seen - ray.target_weight.rgb, forward, slopes);
    ray_loss[ray_index] = loss;
    if (!finite(loss)) atomicOr(state.nonfinite, 1u); // the step is not taken

    slopes = transient_slopes(weight * slopes.colour, weight * slopes.uncertainty, weight * slopes.density);
    seen_back(ray_index, seen, weight, backdrop, left, slopes.colour);
    float behind = left * dot(slopes.colour, backdrop);
    for (uint i = SAMPLES; i-- > 0u;) {
        uint slot = first + i;
        transient_gradient gradient = march_both_back(behind, d_field[slot].w, field[slot], transient_at(slot),
                                                      sample_length(ray, slot, i), slopes);
        d_field[slot] = gradient.field;
        d_layer_rows[VW_ROW_PLACE(D_LAYER_ROWS, D_TRANSIENT_ROW, slot)] = gradient.logit_density;
        d_layer_rows[VW_ROW_PLACE(D_LAYER_ROWS, D_TRANSIENT_ROW + 1u, slot)] =
            vec4(gradient.uncertainty, 0.0, 0.0, 0.0);
    }
}
