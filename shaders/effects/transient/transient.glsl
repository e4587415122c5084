// The part of a photo that the others do not show: a second density with its own colours, composited together with the
// field's, and the uncertainty that it adds to a ray's colour (NeRF-W, Martin-Brualla et al., CVPR 2021, equations 8 to
// 13), forward and backward.
//   weight_i = T_i opacity(tau_i), transient_weight_i = T_i opacity(transient tau_i), T_i = exp(-sum of both tau before
//   i) colour = sum (weight_i rgb_i + transient_weight_i transient_rgb_i) + T_end backdrop, beta = BETA_MIN + sum
//   transient_weight_i beta_i
#ifndef TRANSIENT_GLSL
#define TRANSIENT_GLSL
#include "networks/activations.glsl"
#include "rays/composite.glsl"

struct transient_sample {
    vec3 rgb;
    float density, uncertainty; // both at least 0
};

// Returns log(1 + exp(x)), by its series if log would lose digits; its slope is opacity(softplus(x)).
float softplus(float x) {
    float y = exp(at_most(x, 20.0)), series = y * (1.0 - y * (0.5 - y * (1.0 / 3.0 - y * 0.25)));
    return x > 20.0 ? x : x < -4.0 ? series : log(1.0 + y);
}

transient_sample activate_transient(vec4 logit_density, float raw_uncertainty) {
    return transient_sample(vec3(sigmoid(logit_density.x), sigmoid(logit_density.y), sigmoid(logit_density.z)),
                            softplus(logit_density.w), softplus(raw_uncertainty));
}

struct transient_march {
    float tau; // sums so far, of both densities
    vec3 colour;
    float uncertainty, density; // density: the transient one's plain sum
};

void march_both(inout transient_march ray, vec4 rgb_density, transient_sample passing, float stratum) {
    float tau = rgb_density.w * stratum, transient_tau = passing.density * stratum, reached = transmittance(ray.tau);
    float transient_weight = reached * opacity(transient_tau);
    ray.colour += reached * opacity(tau) * rgb_density.rgb + transient_weight * passing.rgb;
    ray.uncertainty += transient_weight * passing.uncertainty;
    ray.density += passing.density;
    ray.tau += tau + transient_tau;
}

// Gradients of the loss by what a ray is composited to; density: by each transient density, of the penalty.
struct transient_slopes {
    vec3 colour;
    float uncertainty, density;
};

// Gradients by a sample's numbers: rgb and raw density; logits and raw transient density; raw uncertainty.
struct transient_gradient {
    vec4 field, logit_density;
    float uncertainty;
};

// Marches from the last sample to the first. `behind` is the first-order change of the loss by the samples after this
// one and the backdrop.
transient_gradient march_both_back(inout float behind, float tau_before, vec4 rgb_density, transient_sample passing,
                                   float stratum, transient_slopes slopes) {
    float tau = rgb_density.w * stratum, transient_tau = passing.density * stratum, reached = transmittance(tau_before);
    float weight = reached * opacity(tau), transient_weight = reached * opacity(transient_tau);
    float shown = dot(slopes.colour, rgb_density.rgb);
    float transient_shown = dot(slopes.colour, passing.rgb) + slopes.uncertainty * passing.uncertainty;
    float d_tau = transmittance(tau_before + tau) * shown - behind;
    float d_density = stratum * (transmittance(tau_before + transient_tau) * transient_shown - behind) + slopes.density;
    behind += weight * shown + transient_weight * transient_shown;
    transient_gradient gradient;
    gradient.field = vec4(weight * slopes.colour, d_tau * tau);
    gradient.logit_density = vec4(transient_weight * slopes.colour * passing.rgb * (1.0 - passing.rgb),
                                  d_density * opacity(passing.density));
    gradient.uncertainty = slopes.uncertainty * transient_weight * opacity(passing.uncertainty);
    return gradient;
}

const float TRANSIENT_PENALTY = 0.01; // NeRF-W's lambda_u

// Returns a ray's loss: NeRF-W's times 2 BETA_MIN^2, plus a constant. With the least uncertainty it is the squared
// loss.
//   (BETA_MIN / beta)^2 mean error^2 + 2 BETA_MIN^2 (log(beta / BETA_MIN) + TRANSIENT_PENALTY mean transient density)
float transient_loss(vec3 error, transient_march ray, out transient_slopes slopes) {
    float beta = BETA_MIN + ray.uncertainty, trust = BETA_MIN / beta, square = dot(error, error) / 3.0;
    const float scale = 2.0 * BETA_MIN * BETA_MIN, penalty = TRANSIENT_PENALTY / float(SAMPLES);
    slopes.colour = trust * trust * (2.0 / 3.0) * error;
    slopes.uncertainty = (scale - 2.0 * trust * trust * square) / beta;
    slopes.density = scale * penalty;
    return trust * trust * square + scale * (log(beta / BETA_MIN) + penalty * ray.density);
}

#endif
