// The sky, seen if the field does not absorb all light: a learned colour by direction, forward and backward.
//   sky(direction) = sigmoid(sum over k of basis_k(direction) sky_k), with spherical harmonics of bands 0 to 2 and rgb
//   coefficients.
// Such a smooth colour cannot represent an object. It costs 27 numbers; without it the field would have to build a dome
// of density at its box's walls.
#ifndef SKY_GLSL
#define SKY_GLSL
#include "networks/activations.glsl"
#include "networks/spherical_harmonics.glsl"

BUFFER(VW_SLOT_SKY) readonly buffer Sky { vec4 sky[]; };

float sky_basis(vec3 direction, uint k) {
    vec4 low, high;
    spherical_harmonics(direction, low, high);
    if (k == 0u) return SH_BAND0;
    if (k < 5u) return low[k - 1u];
    return high[k - 5u];
}

vec3 sky_colour(vec3 direction) {
    vec3 logit = vec3(0.0);
    [[unroll]] for (uint k = 0u; k < VW_SKY_COLUMNS; k++) logit += sky_basis(direction, k) * sky[k].rgb;
    return vec3(sigmoid(logit.x), sigmoid(logit.y), sigmoid(logit.z));
}

// Returns the gradient by the logit for a ray of which the share `left` reaches the sky of this colour.
vec3 sky_gradient(vec3 colour, float left, vec3 d_colour) { return left * d_colour * colour * (1.0 - colour); }

#endif
