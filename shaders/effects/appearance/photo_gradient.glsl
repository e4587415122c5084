// The gradient by gain and bias of the step's photo: one workgroup sums what its rays say in a fixed order, each
// invocation every 64th, then the first the 64 sums. The result counts in the first invocation alone.
#ifndef PHOTO_GRADIENT_GLSL
#define PHOTO_GRADIENT_GLSL

BUFFER(VW_SLOT_D_APPEARANCE) readonly buffer DAppearance { vw_appearance d_appearance[]; };
shared vec4 gain_sums[64], bias_sums[64];

vw_appearance sum_photo_gradient(uint ray_count) {
    uint lane = gl_LocalInvocationID.x;
    vec4 d_gain = vec4(0.0), d_bias = vec4(0.0);
    for (uint i = lane; i < ray_count; i += 64u) {
        d_gain += d_appearance[i].gain;
        d_bias += d_appearance[i].bias;
    }
    gain_sums[lane] = d_gain;
    bias_sums[lane] = d_bias;
    barrier();
    if (lane == 0u)
        for (uint i = 1u; i < 64u; i++) {
            d_gain += gain_sums[i];
            d_bias += bias_sums[i];
        }
    return vw_appearance(d_gain, d_bias);
}

#endif
