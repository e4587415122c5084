// Moves gain and bias of the step's photo (photo_adam.glsl). One workgroup.
#include "networks/photo_adam.glsl"
#include "effects/appearance/photo_gradient.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_APPEARANCE) buffer Appearance { vw_appearance appearance[]; };
BUFFER(VW_SLOT_APPEARANCE_MOMENTS) buffer Moments { vw_appearance_moments moments[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };

void main() {
    vw_appearance gradient = sum_photo_gradient(push.count);
    vec4 d_gain = gradient.gain, d_bias = gradient.bias;
    if (gl_LocalInvocationID.x != 0u || state.nonfinite != 0u) return; // the step is skipped
    if (!finite(d_gain) || !finite(d_bias)) {                          // before any other param moves
        state.nonfinite = 1u;
        return;
    }
    vw_appearance photo = appearance[state.view];
    vw_appearance_moments moment = moments[state.view];
    moment.visits = next_visit(moment.visits);
    float rate = photo_rate(moment.visits);
    d_gain = d_gain * INVERSE_RAYS + PHOTO_RIDGE * photo.gain;
    d_bias = d_bias * INVERSE_RAYS + PHOTO_RIDGE * photo.bias;
    photo.gain -= photo_step(rate, d_gain, moment.visits, moment.gain1, moment.gain2);
    photo.bias -= photo_step(rate, d_bias, moment.visits, moment.bias1, moment.bias2);
    if (!stays_finite(finite(photo.gain) && finite(photo.bias))) return;
    appearance[state.view] = photo;
    moments[state.view] = moment;
}
