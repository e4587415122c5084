// Computes the vector that the code of the step's photo adds to the colour network (NeRF-W, Martin-Brualla et al., CVPR
// 2021: "appearance embedding"). All rays of a step belong to one photo, so all samples share the product of code
// weights and code. The network's input 0 is constant, and forward_field adds the vector to the weights of that input.
// Validation and rendering use the code 0 instead. One hidden unit per invocation.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_CODE_WEIGHTS) readonly buffer CodeWeights { vec4 code_weights[]; };
BUFFER(VW_SLOT_CODES) readonly buffer Codes { vec4 codes[]; };
BUFFER(VW_SLOT_CODE_SHIFT) writeonly buffer CodeShift { float code_shift[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };

void main() {
    uint unit = invocation_index();
    if (unit >= 4u * WIDTH4) return;
    float sum = 0.0;
    for (uint k = 0u; k < CODE4; k++) sum += dot(code_weights[CODE4 * unit + k], codes[CODE4 * state.view + k]);
    code_shift[unit] = sum;
}
