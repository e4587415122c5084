// Computes a photo's code from the last convolution of the encoder of photos (encoder.glsl), and what it adds to the
// colour network, as mix_code does. One workgroup.
#include "effects/appearance_encoder/encoder.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
BUFFER(VW_SLOT_ENCODER_ROWS) buffer Rows { vec4 rows[]; };
BUFFER(VW_SLOT_CODE_SHIFT) writeonly buffer CodeShift { vec4 code_shift[]; };

const uint PIXELS = 16u; // pixels of the last convolution
shared vec4 mean[ENCODER4];
shared vec4 code[CODE4];

mat4 block_at(uint column) {
    uint at = ENCODER_COLUMN + column;
    return mat4(weights[at], weights[at + 1u], weights[at + 2u], weights[at + 3u]);
}

vec4 mean_of(uint in4) {
    vec4 sum = vec4(0.0);
    for (uint pixel = 0u; pixel < PIXELS; pixel++) sum += rows[ENCODER_ROW_LAYER3 + ENCODER4 * pixel + in4];
    return sum / float(PIXELS);
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    if (lane < ENCODER4) {
        mean[lane] = mean_of(lane);
        rows[ENCODER_ROW_MEAN + lane] = mean[lane];
    }
    barrier();
    if (lane < CODE4) {
        vec4 sum = weights[ENCODER_COLUMN + ENCODER_CODE_BIAS + lane];
        for (uint in4 = 0u; in4 < ENCODER4; in4++)
            sum += block_at(ENCODER_CODE + 4u * (ENCODER4 * lane + in4)) * mean[in4];
        code[lane] = sum;
        rows[ENCODER_ROW_CODE + lane] = sum;
    }
    barrier();
    for (uint unit4 = lane; unit4 < WIDTH4; unit4 += 64u) {
        vec4 sum = vec4(0.0);
        for (uint k = 0u; k < CODE4; k++) sum += block_at(ENCODER_SHIFT + 4u * (CODE4 * unit4 + k)) * code[k];
        code_shift[unit4] = sum;
    }
}
