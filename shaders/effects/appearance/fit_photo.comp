// The gain and bias per channel of the step's photo, by ridge regression of the photo on what was rendered at its last
// visits; the field's own steps follow (variable projection, Golub and Pereyra, 1973). One workgroup sums what rays
// say, in a fixed order.
//
// With L the rendered and c the photo's colour of n rays, d = c - L, the gain 1 + g and the bias b minimise
//   sum (g L + b - d)^2 + FIT_RIDGE g^2 + (FIT_RIDGE + BIAS_PULL n) b^2
// over all visits, older ones faded by FADE each, since the field was another. A ray through a transparent pixel shows
// some of the background, and pulls the photo towards what it is. Fits of all photos are centred: without that, they
// drift together while the field's colours follow, and a fixed background does not.
#include "effects/appearance/appearance.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_RENDERED) readonly buffer Rendered { vec4 rendered[]; };
BUFFER(VW_SLOT_APPEARANCE) buffer Appearance { vw_appearance appearance[]; };
BUFFER(VW_SLOT_PHOTO_SUMS) buffer Sums { vw_photo_sums sums[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_update push; };

const float FADE = 0.5;
// A bias takes up lost contrast, as of a blurred photo, sooner than a change of exposure.
const float BIAS_PULL = 0.1;
const float GAIN_LEAST = -0.9; // photos are divided by 1 + g
const float VISITS_HELD = 3.0; // in which the field becomes more than fog, beside which all photos are alike

shared vw_photo_sums of_lanes[64];

vw_photo_sums add(vw_photo_sums a, vw_photo_sums b, float times) {
    return vw_photo_sums(a.rendered + times * b.rendered, a.squares + times * b.squares, a.missing + times * b.missing,
                         a.products + times * b.products, a.gain + times * b.gain, a.bias + times * b.bias);
}

// Sums every 64th ray, and the last fits of every 64th of the other photos.
vw_photo_sums sum_lane(vw_appearance photo) {
    const vec4 zero = vec4(0.0);
    vw_photo_sums sum = vw_photo_sums(zero, zero, zero, zero, zero, zero);
    for (uint i = gl_LocalInvocationID.x; i < push.count; i += 64u) {
        vec3 target = rays[i].target_weight.rgb; // black and white may be clipped, and then tell nothing
        bool usable = all(greaterThan(target, vec3(0.0))) && all(lessThan(target, vec3(1.0)));
        vec4 colour = vec4(rendered[i].rgb, 1.0), missing = vec4(appear(photo, target) - rendered[i].rgb, 0.0);
        vw_photo_sums ray = vw_photo_sums(colour, colour * colour, missing, colour * missing, zero, zero);
        sum = add(sum, ray, usable ? rendered[i].w : 0.0);
    }
    for (uint v = gl_LocalInvocationID.x; v < sums.length(); v += 64u) {
        if (v == state.view || sums[v].gain.w == 0.0) continue;
        sum.gain += vec4(sums[v].gain.rgb, 1.0);
        sum.bias += sums[v].bias;
    }
    return sum;
}

// Sums what all lanes found; the result counts in the first alone.
vw_photo_sums sum_up(vw_appearance photo) {
    vw_photo_sums sum = sum_lane(photo);
    of_lanes[gl_LocalInvocationID.x] = sum;
    barrier();
    if (gl_LocalInvocationID.x == 0u)
        for (uint i = 1u; i < 64u; i++) sum = add(sum, of_lanes[i], 1.0);
    return sum;
}

// Solves the normal equations. What is not finite stays so, which max() would hide.
vw_appearance solve(vw_photo_sums sum) {
    float count = sum.rendered.w, biases = count + FIT_RIDGE + BIAS_PULL * count;
    vec3 squares = sum.squares.rgb + FIT_RIDGE;
    vec3 determinant = squares * biases - sum.rendered.rgb * sum.rendered.rgb;
    vec3 gain = (sum.products.rgb * biases - sum.rendered.rgb * sum.missing.rgb) / determinant;
    if (finite(vec4(gain, 0.0))) gain = max(gain, vec3(GAIN_LEAST));
    return vw_appearance(vec4(gain, 0.0), vec4((sum.missing.rgb - gain * sum.rendered.rgb) / biases, 0.0));
}

// Makes the mean fit the identity.
vw_appearance centre(vw_appearance photo, vec4 gains, vec4 biases) {
    vec3 gain = (1.0 + photo.gain.rgb) / (1.0 + gains.rgb / gains.w) - 1.0;
    gain = max(gain, vec3(GAIN_LEAST));
    return vw_appearance(vec4(gain, 0.0), vec4(photo.bias.rgb - (1.0 + gain) * biases.rgb / gains.w, 0.0));
}

void main() {
    vw_photo_sums sum = sum_up(appearance[state.view]), old = sums[state.view];
    if (gl_LocalInvocationID.x != 0u || state.nonfinite != 0u) return; // the step is skipped
    vec4 gains = sum.gain, biases = sum.bias;
    sum = add(sum, old, FADE);
    vw_appearance photo = solve(sum);
    if (!finite(photo.gain) || !finite(photo.bias)) { // before any other param moves
        state.nonfinite = 1u;
        return;
    }
    sum.gain = vec4(photo.gain.rgb, old.gain.w + 1.0);
    sum.bias = photo.bias;
    sums[state.view] = sum;
    bool known = sum.gain.w > VISITS_HELD;
    photo = centre(photo, gains + vec4(photo.gain.rgb, 1.0), biases + photo.bias);
    appearance[state.view] = vw_appearance(known ? photo.gain : vec4(0.0), known ? photo.bias : vec4(0.0));
}
