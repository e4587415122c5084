// A convolution of the encoder of photos (encoder.glsl): four channels of one pixel per invocation. In the variant
// VW_BACK from the gradients by its sums to those by the sums of the convolution before it.
#include "effects/appearance_encoder/encoder.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
PUSH uniform Push { vw_push_photo push; };

#ifdef VW_BACK
BUFFER(VW_SLOT_ENCODER_ROWS) readonly buffer Rows { vec4 rows[]; };
BUFFER(VW_SLOT_D_ENCODER_ROWS) buffer DRows { vec4 d_rows[]; };

#include "networks/kernels.glsl"

void main() {
    uint index = invocation_index(), before = push.layer - 1u, side = side_of(before);
    if (index >= side * side * ENCODER4) return;
    uint pixel = index / ENCODER4, in4 = index % ENCODER4, row = row_of(before, uvec2(pixel % side, pixel / side), in4);
    vec4 gradient = input_gradient(push.layer, uvec2(pixel % side, pixel / side), in4);
    d_rows[row] = mix(vec4(0.0), gradient, greaterThan(rows[row], vec4(0.0)));
}
#else
BUFFER(VW_SLOT_THUMBNAILS) readonly buffer Thumbnails { vec4 thumbnails[]; };
BUFFER(VW_SLOT_ENCODER_ROWS) buffer Rows { vec4 rows[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };

#include "networks/kernels.glsl"

vec4 input_at(uint view, uvec2 place, uint in4) {
    if (push.layer == 0u) return thumbnails[THUMBNAIL_PIXELS * view + THUMBNAIL_SIDE * place.y + place.x];
    return rows[row_of(push.layer - 1u, place, in4)];
}

void main() {
    uint index = invocation_index(), side = side_of(push.layer), view = TRAINING != 0u ? state.view : push.view;
    if (index >= side * side * ENCODER4) return;
    uint pixel = index / ENCODER4, out4 = index % ENCODER4;
    uvec2 at = uvec2(pixel % side, pixel / side);
    vec4 sum = weights[ENCODER_COLUMN + column_of(push.layer) + bias_of(push.layer) + out4];
    for (uint tap = 0u; tap < ENCODER_TAPS; tap++) {
        ivec2 place = place_of(at, tap);
        if (!is_within(place, 2u * side)) continue;
        for (uint in4 = 0u; in4 < inputs4_of(push.layer); in4++)
            sum += kernel_block(push.layer, tap, out4, in4) * input_at(view, uvec2(place), in4);
    }
    rows[row_of(push.layer, at, out4)] = rectify(sum);
}
#endif
