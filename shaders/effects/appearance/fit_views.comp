// The gain and bias per channel that bring what is rendered of a validation view nearest to its photo, by ridge
// regression on rays of its left half: reduce_views then scores the right half (the protocol of NeRF-W, Martin-Brualla
// et al., CVPR 2021, in closed form). One workgroup per view, in an order that is fixed.
//
// With r the rendered and t the target colour of n rays, d = t - r, the gain 1 + g and the bias b minimise
//   sum (g r + b - d)^2 + FIT_RIDGE (g^2 + b^2)
// which, with r', d' measured from their means r_, d_, is solved by
//   g = (sum r' d' + w r_ d_) / (sum r' r' + w r_ r_ + FIT_RIDGE),  b = n / (n + FIT_RIDGE) (d_ - g r_),  w = n
//   FIT_RIDGE / (n + FIT_RIDGE)
// without a difference of large sums, and with a denominator above 0 whatever the rays show: a flat half leaves the
// gain near 1, no ray at all leaves the view as it is rendered.
#include "effects/appearance/appearance.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_COLOURS) readonly buffer Colours { vec4 colours[]; };
BUFFER(VW_SLOT_VAL_VIEWS) readonly buffer Views { vw_ray_range views[]; };
BUFFER(VW_SLOT_FITS) writeonly buffer Fits { vw_appearance fits[]; };
PUSH uniform Push { vw_push_reduce push; };

shared vec4 sums1[64], sums2[64];

// Adds up the values of all invocations and returns the sums to all.
void add_up(inout vec4 sum1, inout vec4 sum2) {
    sums1[gl_LocalInvocationID.x] = sum1;
    sums2[gl_LocalInvocationID.x] = sum2;
    barrier();
    sum1 = vec4(0.0);
    sum2 = vec4(0.0);
    for (uint i = 0u; i < 64u; i++) {
        sum1 += sums1[i];
        sum2 += sums2[i];
    }
    barrier();
}

// Reads the rendered colour and the photo's difference from it; w is 1 if the ray counts.
void look_at(uint ray, out vec4 rendered, out vec4 missing) {
    vec4 target_weight = rays[ray].target_weight;
    float counts = target_weight.w == 0.0 ? 0.0 : 1.0;
    rendered = vec4(colours[ray].rgb, counts);
    missing = vec4(target_weight.rgb - colours[ray].rgb, counts);
}

void main() {
    uint view = workgroup_index(), lane = gl_LocalInvocationID.x;
    vw_ray_range range = views[min(view, push.count - 1u)];
    vec4 rendered, missing, rendered_sum = vec4(0.0), missing_sum = vec4(0.0);
    for (uint i = lane; i < range.count; i += 64u) {
        look_at(range.first + i, rendered, missing);
        rendered_sum += rendered.w * rendered;
        missing_sum += missing.w * missing;
    }
    add_up(rendered_sum, missing_sum);
    float count = rendered_sum.w;
    vec4 rendered_mean = rendered_sum / max(count, 1.0), missing_mean = missing_sum / max(count, 1.0);

    vec4 squares = vec4(0.0), products = vec4(0.0);
    for (uint i = lane; i < range.count; i += 64u) {
        look_at(range.first + i, rendered, missing);
        vec4 centred = rendered - rendered_mean;
        squares += rendered.w * centred * centred;
        products += rendered.w * centred * (missing - missing_mean);
    }
    add_up(squares, products);
    if (lane != 0u || view >= push.count) return;
    float share = count / (count + FIT_RIDGE), pull = share * FIT_RIDGE;
    vec3 gain = (products.rgb + pull * rendered_mean.rgb * missing_mean.rgb) /
                (squares.rgb + pull * rendered_mean.rgb * rendered_mean.rgb + FIT_RIDGE);
    vec3 bias = share * (missing_mean.rgb - gain * rendered_mean.rgb);
    fits[view] = vw_appearance(vec4(gain, 0.0), vec4(bias, 0.0));
}
