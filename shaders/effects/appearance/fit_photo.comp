// The gain and bias per channel of the step's photo, by ridge regression of the photo on what was rendered at its last
// visits; the field's own steps follow (variable projection, Golub and Pereyra, 1973). One workgroup sums what rays
// say, in a fixed order.
//
// With L the rendered and c the photo's colour of n rays, d = c - L, the gain 1 + g and the bias b minimise
//   sum (g L + b - d)^2 + (FIT_RIDGE + GAIN_PULL n) g^2 + (FIT_RIDGE + BIAS_PULL n) b^2
// over all visits, older ones faded by FADE each, since the field was another. A ray through a transparent pixel shows
// some of the background, and pulls the photo towards what it is.
#include "effects/appearance/appearance.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_RENDERED) readonly buffer Rendered { vec4 rendered[]; };
BUFFER(VW_SLOT_APPEARANCE) buffer Appearance { vw_appearance appearance[]; };
BUFFER(VW_SLOT_PHOTO_SUMS) buffer Sums { vw_photo_sums sums[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_update push; };

const float FADE = 0.5;
// All gains could rise while the field's colours fall: a small pull towards 1 keeps them. A bias takes up lost
// contrast, as of a blurred photo, sooner than a change of exposure.
const float GAIN_PULL = 0.003, BIAS_PULL = 0.1;
const float GAIN_LEAST = -0.9; // photos are divided by 1 + g

shared vw_photo_sums of_lanes[64];

vw_photo_sums add(vw_photo_sums a, vw_photo_sums b) {
    return vw_photo_sums(a.rendered + b.rendered, a.squares + b.squares, a.missing + b.missing,
                         a.products + b.products);
}

// Sums every 64th ray, then the sums of all lanes; the result counts in the first alone.
vw_photo_sums sum_rays(vw_appearance photo) {
    uint lane = gl_LocalInvocationID.x;
    vw_photo_sums sum = vw_photo_sums(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    for (uint i = lane; i < push.count; i += 64u) {
        vec3 target = rays[i].target_weight.rgb; // black and white may be clipped, and then tell nothing
        bool usable = all(greaterThan(target, vec3(0.0))) && all(lessThan(target, vec3(1.0)));
        float weight = usable ? rendered[i].w : 0.0;
        vec4 colour = vec4(rendered[i].rgb, 1.0), missing = vec4(appear(photo, target) - rendered[i].rgb, 0.0);
        vw_photo_sums ray = vw_photo_sums(colour, colour * colour, missing, colour * missing);
        sum = add(sum, vw_photo_sums(weight * ray.rendered, weight * ray.squares, weight * ray.missing,
                                     weight * ray.products));
    }
    of_lanes[lane] = sum;
    barrier();
    if (lane == 0u)
        for (uint i = 1u; i < 64u; i++) sum = add(sum, of_lanes[i]);
    return sum;
}

// Solves the normal equations. What is not finite stays so, which max() would hide.
vw_appearance solve(vw_photo_sums sum) {
    float count = sum.rendered.w, biases = count + FIT_RIDGE + BIAS_PULL * count;
    vec3 squares = sum.squares.rgb + FIT_RIDGE + GAIN_PULL * count;
    vec3 determinant = squares * biases - sum.rendered.rgb * sum.rendered.rgb;
    vec3 gain = (sum.products.rgb * biases - sum.rendered.rgb * sum.missing.rgb) / determinant;
    if (finite(vec4(gain, 0.0))) gain = max(gain, vec3(GAIN_LEAST));
    return vw_appearance(vec4(gain, 0.0), vec4((sum.missing.rgb - gain * sum.rendered.rgb) / biases, 0.0));
}

void main() {
    vw_photo_sums sum = sum_rays(appearance[state.view]), old = sums[state.view];
    if (gl_LocalInvocationID.x != 0u || state.nonfinite != 0u) return; // the step is skipped
    sum = add(sum, vw_photo_sums(FADE * old.rendered, FADE * old.squares, FADE * old.missing, FADE * old.products));
    vw_appearance photo = solve(sum);
    if (!finite(photo.gain) || !finite(photo.bias)) { // before any other param moves
        state.nonfinite = 1u;
        return;
    }
    appearance[state.view] = photo;
    sums[state.view] = sum;
}
