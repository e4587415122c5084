// Gradients by the weights of all convolutions of the encoder of photos (encoder.glsl), over pixels in their order,
// where update_weights reads them: of the sum over rays. One column per invocation. Anything not finite marks the step.
#include "effects/appearance_encoder/encoder.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_THUMBNAILS) readonly buffer Thumbnails { vec4 thumbnails[]; };
BUFFER(VW_SLOT_ENCODER_ROWS) readonly buffer Rows { vec4 rows[]; };
BUFFER(VW_SLOT_D_ENCODER_ROWS) readonly buffer DRows { vec4 d_rows[]; };
BUFFER(VW_SLOT_D_WEIGHTS) writeonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };

// Returns the first pixel of the photo, or outside training that of the rendered picture.
uint first_pixel() { return TRAINING != 0u ? THUMBNAIL_PIXELS * state.view : 0u; }

vec4 input_at(uint layer, uvec2 place, uint in4) {
    if (layer == 0u) return thumbnails[first_pixel() + THUMBNAIL_SIDE * place.y + place.x];
    return rows[row_of(layer - 1u, place, in4)];
}

// Returns the gradient by column `of_layer` of the convolution.
vec4 column_gradient(uint layer, uint of_layer) {
    uint block = of_layer / 4u, in4 = block % inputs4_of(layer), side = side_of(layer);
    bool is_bias = of_layer >= bias_of(layer);
    uint out4 = is_bias ? of_layer - bias_of(layer) : block / inputs4_of(layer) % ENCODER4;
    uint tap = block / inputs4_of(layer) / ENCODER4;
    vec4 sum = vec4(0.0);
    for (uint pixel = 0u; pixel < side * side; pixel++) {
        uvec2 at = uvec2(pixel % side, pixel / side);
        ivec2 place = place_of(at, tap);
        vec4 gradient = d_rows[row_of(layer, at, out4)];
        if (is_bias) sum += gradient;
        else if (is_within(place, 2u * side)) sum += gradient * input_at(layer, uvec2(place), in4)[of_layer % 4u];
    }
    return sum;
}

void main() {
    uint column = invocation_index();
    if (column >= ENCODER_CODE) return;
    uint layer = uint(column >= ENCODER_LAYER2) + uint(column >= ENCODER_LAYER3);
    vec4 gradient = column_gradient(layer, column - column_of(layer));
    d_weights[ENCODER_COLUMN + column] = gradient;
    if (!finite(gradient)) atomicOr(state.nonfinite, 1u);
}
