// Emission-absorption compositing of one ray (Max, "Optical models for direct volume rendering", 1995), forward and
// backward.
//   tau_i = density_i * length of its stratum, weight_i = exp(-sum of tau before i) (1 - exp(-tau_i)),
//   colour = sum weight_i rgb_i + T_end backdrop
// The sum of tau is accumulated rather than a product of transmittances, and the backward pass needs no division.
#ifndef COMPOSITE_GLSL
#define COMPOSITE_GLSL

// Returns exp(-tau). exp flushes to 0 below 1e-38; beyond tau = 87 nothing is visible. A comparison limits tau, since
// min could turn NaN into 87 (decision 8).
float transmittance(float tau) { return exp(tau > 87.0 ? -87.0 : -tau); }

// Returns 1 - exp(-tau), by its series if the difference would lose digits.
float opacity(float tau) {
    float series = tau * (1.0 - tau * (0.5 - tau * (1.0 / 6.0 - tau * (1.0 / 24.0))));
    return tau < 0.03 ? series : 1.0 - transmittance(tau);
}

// Forward, sample by sample.
struct ray_march {
    float tau;   // sum so far
    vec3 colour; // sum so far
};

void march(inout ray_march ray, vec4 rgb_density, float stratum) {
    float tau = rgb_density.w * stratum;
    ray.colour += transmittance(ray.tau) * opacity(tau) * rgb_density.rgb;
    ray.tau += tau;
}

// Returns the gradients by rgb_i and by the raw density (d tau / d raw = tau), from the last sample to the first.
// `behind` is the colour composited behind sample i, seen from the camera: it starts as T_end * backdrop.
vec4 march_back(inout vec3 behind, float tau_before, vec4 rgb_density, float stratum, vec3 d_colour) {
    float tau = rgb_density.w * stratum;
    float weight = transmittance(tau_before) * opacity(tau);
    vec3 seen = transmittance(tau_before + tau) * rgb_density.rgb;
    float d_tau = dot(d_colour, seen - behind);
    behind += weight * rgb_density.rgb;
    return vec4(d_colour * weight, d_tau * tau);
}

#endif
