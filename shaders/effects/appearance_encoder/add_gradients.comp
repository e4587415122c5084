// Adds the gradients of the consistency loss to those of the step. Of the matrix from a code to what it adds to the
// colour network they follow here, as in spread_photo, with the code that was given. One column per invocation.
// Anything not finite marks the step.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_D_WEIGHTS) buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_OWN_D_WEIGHTS) readonly buffer OwnDWeights { vec4 own[]; };
BUFFER(VW_SLOT_GIVEN_ROWS) readonly buffer GivenRows { vec4 given_rows[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };

vec4 own_gradient(uint column) {
    uint first = ENCODER_COLUMN + ENCODER_SHIFT, i = max(column, first) - first, unit4 = i / 4u / CODE4;
    if (column < first || unit4 >= WIDTH4) return own[column];
    return own[SHIFT_COLUMN + SHIFT_STRIDE * unit4] * given_rows[ENCODER_ROW_CODE + i / 4u % CODE4][i % 4u];
}

void main() {
    uint column = invocation_index();
    if (column >= d_weights.length()) return;
    vec4 sum = d_weights[column] + own_gradient(column);
    d_weights[column] = sum;
    if (!finite(sum)) atomicOr(state.nonfinite, 1u);
}
