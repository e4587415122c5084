// The slope of validation's score by the colour of each of its rays: the mean over views of PSNR, or minus the mean
// absolute error; of all views, or of a single one. Runs after reduce_views. The passes that use the gradient apply
// constant factors. One workgroup per view, in a fixed order.
//
// If gain and bias are fitted to a view (fit_views), its score also depends on the rays of its left half. With a = 1
// + gain, b the bias, r the rendered colour and t the photo's, the fit solves M (a, b) = v with
//   M = (sum r r + FIT_RIDGE, sum r; sum r, n + FIT_RIDGE),  v = (sum r t + FIT_RIDGE, sum t)
// so that with y = M^-1 (score's slope by a, by b) the slope by r of a ray with the error e = a r + b - t is -(y_a e +
// a (y_a r + y_b)).
#include "effects/appearance/appearance.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_COLOURS) readonly buffer Colours { vec4 colours[]; };
BUFFER(VW_SLOT_VAL_VIEWS) readonly buffer Views { vw_ray_range views[]; };
BUFFER(VW_SLOT_FIT_VIEWS) readonly buffer FitViews { vw_ray_range fit_views[]; };
BUFFER(VW_SLOT_FITS) readonly buffer Fits { vw_appearance fits[]; };
BUFFER(VW_SLOT_SCALARS) readonly buffer Scalars { vec4 scalars[]; };
BUFFER(VW_SLOT_GATHERED) buffer Slopes { vw_ray slopes[]; };
PUSH uniform Push { vw_push_slopes push; };

const float DECIBEL = 8.6858896;   // 20 / ln 10: PSNR's slope by the root of the squared error
const float SQUARED_FLOOR = 3e-10; // a pixel's squared error at 100 dB, where PSNR is capped

shared vec3 sums1[64], sums2[64];

// Adds up the values of all invocations and returns the sums to all.
void add_up(inout vec3 sum1, inout vec3 sum2) {
    sums1[gl_LocalInvocationID.x] = sum1;
    sums2[gl_LocalInvocationID.x] = sum2;
    barrier();
    sum1 = vec3(0.0);
    sum2 = vec3(0.0);
    for (uint i = 0u; i < 64u; i++) {
        sum1 += sums1[i];
        sum2 += sums2[i];
    }
    barrier();
}

void slope_fitted(uint view, vec3 gain, vec3 bias, vec3 by_gain, vec3 by_bias) {
    vw_ray_range range = fit_views[view];
    vec3 squares = vec3(0.0), rendered = vec3(0.0), counts = vec3(0.0), unused = vec3(0.0);
    for (uint i = range.first + gl_LocalInvocationID.x; i < range.first + range.count; i += 64u) {
        if (rays[i].target_weight.w == 0.0) continue;
        squares += colours[i].rgb * colours[i].rgb;
        rendered += colours[i].rgb;
        counts += 1.0;
    }
    add_up(squares, rendered);
    add_up(counts, unused);
    squares += FIT_RIDGE;
    counts += FIT_RIDGE;
    vec3 determinant = squares * counts - rendered * rendered;
    vec3 pull_gain = (counts * by_gain - rendered * by_bias) / determinant;
    vec3 pull_bias = (squares * by_bias - rendered * by_gain) / determinant;
    for (uint i = range.first + gl_LocalInvocationID.x; i < range.first + range.count; i += 64u) {
        vec4 target_weight = rays[i].target_weight;
        vec3 error = gain * colours[i].rgb + bias - target_weight.rgb;
        vec3 slope = -(pull_gain * error + gain * (pull_gain * colours[i].rgb + pull_bias));
        slopes[i].target_weight.rgb = target_weight.w != 0.0 ? slope : vec3(0.0);
    }
}

void main() {
    uint view = min(workgroup_index(), push.count - 1u);
    bool fits_view = EFFECT_APPEARANCE != 0u || EFFECT_APPEARANCE_CODE != 0u;
    bool counts = push.only_view == VW_ALL_VIEWS || push.only_view == view;
    vw_ray_range range = views[view];
    vec4 sums = scalars[push.scalar_row + 1u + view];
    float squared = sums.x + sums.y;
    float by_error = squared > SQUARED_FLOOR * float(range.count) ? -DECIBEL / squared : 0.0;
    vec3 gain = vec3(1.0), bias = vec3(0.0), by_gain = vec3(0.0), by_bias = vec3(0.0);
    if (fits_view) {
        gain += fits[view].gain.rgb;
        bias = fits[view].bias.rgb;
    }
    for (uint i = range.first + gl_LocalInvocationID.x; i < range.first + range.count; i += 64u) {
        vec4 target_weight = rays[i].target_weight;
        vec3 rendered = colours[i].rgb, error = gain * rendered + bias - target_weight.rgb;
        vec3 slope = push.measure == 0u ? by_error * error : -sign(error);
        if (target_weight.w == 0.0 || !counts) slope = vec3(0.0);
        slopes[i].target_weight.rgb = gain * slope;
        by_gain += slope * rendered;
        by_bias += slope;
    }
    if (!fits_view) return;
    add_up(by_gain, by_bias);
    slope_fitted(view, gain, bias, by_gain, by_bias);
}
