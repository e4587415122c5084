// A photo's own exposure and white balance, applied to rendered colours: a gain and a bias per channel (as in Urban
// Radiance Fields, Rematas et al., CVPR 2022, of whose affine map this is the diagonal). Forward and backward.
#ifndef APPEARANCE_GLSL
#define APPEARANCE_GLSL

// Applies gain and bias. A gain is stored minus 1, so that params of 0 leave colours bit-identical, and a ridge pulls
// to the identity.
vec3 appear(vw_appearance photo, vec3 rendered) { return (1.0 + photo.gain.rgb) * rendered + photo.bias.rgb; }

// Converts the gradient by the seen colour to those by the photo's numbers and by the rendered colour.
vw_appearance appear_back(vw_appearance photo, vec3 rendered, vec3 d_seen, out vec3 d_rendered) {
    d_rendered = (1.0 + photo.gain.rgb) * d_seen;
    return vw_appearance(vec4(d_seen * rendered, 0.0), vec4(d_seen, 0.0));
}

// All gains could rise while the field's colours fall, and all codes drift where the code 0 of rendering is unknown: a
// ridge holds them near 0. Gradient of the mean loss per unit. Gains spread by 0.18 with it, by 0.19 without, by 0.13
// with ten times as much.
const float PHOTO_RIDGE = 0.01;
// The ridge of fit_views, in squared errors: as if one ray were off by 0.3 for a gain or bias of 1. Ten times as much
// cost 0.15 dB, a tenth gave none.
const float FIT_RIDGE = 0.1;

#endif
