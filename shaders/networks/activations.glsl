// The activations of networks: ReLU, sigmoid, and the exponential that makes a density. max, min and clamp may turn NaN
// into a number and so hide it; comparisons keep it (decision 8).
#ifndef ACTIVATIONS_GLSL
#define ACTIVATIONS_GLSL

const float DENSITY_MAX =
    3.0e6; // per box edge; more gains nothing, and its gradient is cut (exp of a raw density near 14.9)

float at_most(float x, float limit) { return x > limit ? limit : x; }
float rectify(float x) { return x < 0.0 ? 0.0 : x; }
vec4 rectify(vec4 v) { return vec4(rectify(v.x), rectify(v.y), rectify(v.z), rectify(v.w)); }
float sigmoid(float x) { return 1.0 / (1.0 + exp(at_most(-x, 80.0))); }
float density_of(float raw) { return at_most(exp(at_most(raw, 80.0)), DENSITY_MAX); }

// Converts a sample's gradients by rgb and raw density (w) to those by the logits; raw_gradient returns that by the raw
// density, which is 0 if the density was limited.
vec4 logit_gradient(vec4 rgb_density, vec4 gradient) {
    return vec4(gradient.rgb * rgb_density.rgb * (1.0 - rgb_density.rgb), 0.0);
}
float raw_gradient(vec4 rgb_density, vec4 gradient) { return rgb_density.w >= DENSITY_MAX ? 0.0 : gradient.w; }

#endif
