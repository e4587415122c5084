// The backward pass of pool_photo. The gradient by the vector added to the colour network equals that by the weights it
// was added to, as in update_code; from there it goes to both matrices and to the sums in the last convolution.
// Gradients are of the sum over rays. A non-finite value marks the step. One workgroup. Variant VW_CODES, for the
// consistency loss: the gradient of the mean L1 between the code of the rendered picture and the given one, which is
// held fixed; it does not involve the matrix after the code.
#include "effects/appearance_encoder/encoder.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
BUFFER(VW_SLOT_D_WEIGHTS) buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_ENCODER_ROWS) readonly buffer Rows { vec4 rows[]; };
BUFFER(VW_SLOT_D_ENCODER_ROWS) writeonly buffer DRows { vec4 d_rows[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };

#ifdef VW_CODES
BUFFER(VW_SLOT_GIVEN_ROWS) readonly buffer GivenRows { vec4 given_rows[]; };
PUSH uniform Push { vw_push_codes push; };
#endif

const uint PIXELS = 16u; // pixels of the last convolution
shared vec4 d_code[CODE4];
shared vec4 d_mean[ENCODER4];

mat4 block_at(uint column) {
    uint at = ENCODER_COLUMN + column;
    return mat4(weights[at], weights[at + 1u], weights[at + 2u], weights[at + 3u]);
}

vec4 d_shift(uint unit4) { return d_weights[SHIFT_COLUMN + SHIFT_STRIDE * unit4]; }

void write(uint column, vec4 gradient) {
    d_weights[ENCODER_COLUMN + column] = gradient;
    if (!finite(gradient)) atomicOr(state.nonfinite, 1u);
}

#ifdef VW_CODES
vec4 code_gradient(uint k) {
    vec4 difference = rows[ENCODER_ROW_CODE + k] - given_rows[ENCODER_ROW_CODE + k], zero = vec4(0.0);
    vec4 down = mix(difference, vec4(-1.0), lessThan(difference, zero)); // keeps NaN
    return push.slope * mix(down, vec4(1.0), greaterThan(difference, zero));
}
#else
vec4 code_gradient(uint k) {
    vec4 sum = vec4(0.0);
    for (uint unit4 = 0u; unit4 < WIDTH4; unit4++)
        sum += d_shift(unit4) * block_at(ENCODER_SHIFT + 4u * (CODE4 * unit4 + k));
    return sum;
}
#endif

vec4 mean_gradient(uint in4) {
    vec4 sum = vec4(0.0);
    for (uint k = 0u; k < CODE4; k++) sum += d_code[k] * block_at(ENCODER_CODE + 4u * (ENCODER4 * k + in4));
    return sum;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    if (lane < CODE4) {
        d_code[lane] = code_gradient(lane);
        write(ENCODER_CODE_BIAS + lane, d_code[lane]);
    }
    barrier();
    if (lane < ENCODER4) d_mean[lane] = mean_gradient(lane);
    barrier();
#ifndef VW_CODES
    for (uint i = lane; i < 4u * CODE4 * WIDTH4; i += 64u) {
        uint k = i / 4u % CODE4;
        write(ENCODER_SHIFT + i, d_shift(i / 4u / CODE4) * rows[ENCODER_ROW_CODE + k][i % 4u]);
    }
#endif
    for (uint i = lane; i < 4u * CODE4 * ENCODER4; i += 64u) {
        uint in4 = i / 4u % ENCODER4;
        write(ENCODER_CODE + i, d_code[i / 4u / ENCODER4] * rows[ENCODER_ROW_MEAN + in4][i % 4u]);
    }
    for (uint i = lane; i < PIXELS * ENCODER4; i += 64u) {
        uint row = ENCODER_ROW_LAYER3 + i;
        d_rows[row] = mix(vec4(0.0), d_mean[i % ENCODER4] / float(PIXELS), greaterThan(rows[row], vec4(0.0)));
    }
}
