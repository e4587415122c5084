// The gradient by gain and bias of the step's photo: of the mean loss with its ridge, as update_appearance takes it,
// and 0 for the other photos; or added to the adjoint by the backward pass, without the ridge, whose curvature is
// small beside the rays'. One workgroup.
#include "effects/appearance/appearance.glsl"
#include "effects/appearance/photo_gradient.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_APPEARANCE) readonly buffer Appearance { vw_appearance appearance[]; };
BUFFER(VW_SLOT_GATHERED) buffer Gathered { vw_appearance gathered[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_ADJOINT_STATE) readonly buffer AdjointState { vw_adjoint_state adjoint; };
PUSH uniform Push { vw_push_gather push; };

void main() {
    uint lane = gl_LocalInvocationID.x;
    vw_appearance gradient = sum_photo_gradient(push.count), zero = vw_appearance(vec4(0.0), vec4(0.0));
    if (push.adds == 0u)
        for (uint i = lane; i < gathered.length(); i += 64u)
            if (i != state.view || state.nonfinite != 0u) gathered[i] = zero;
    if (lane != 0u) return;
    vec4 d_gain = gradient.gain * INVERSE_RAYS, d_bias = gradient.bias * INVERSE_RAYS;
    vw_appearance photo = appearance[state.view], sum = gathered[state.view];
    if (push.adds != 0u) sum = vw_appearance(sum.gain + adjoint.unscale * d_gain, sum.bias + adjoint.unscale * d_bias);
    else if (state.nonfinite != 0u) sum = zero;
    else sum = vw_appearance(d_gain + PHOTO_RIDGE * photo.gain, d_bias + PHOTO_RIDGE * photo.bias);
    gathered[state.view] = sum;
}
