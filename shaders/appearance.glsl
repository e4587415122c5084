// What a photo's own exposure and white balance make of rendered colours: a gain and a bias per channel (as in Urban Radiance Fields,
// Rematas et al., CVPR 2022, of whose affine map this is the diagonal). Forward and backward.
#ifndef APPEARANCE_GLSL
#define APPEARANCE_GLSL

// A gain is held as what it has beyond 1, so that params of 0 change nothing, not even the last bit, and a ridge pulls to the identity.
vec3 appear(vw_appearance photo, vec3 rendered) { return (1.0 + photo.gain.rgb) * rendered + photo.bias.rgb; }

// From the gradient by what is seen to those by the photo's numbers and by what was rendered.
vw_appearance appear_back(vw_appearance photo, vec3 rendered, vec3 d_seen, out vec3 d_rendered) {
    d_rendered = (1.0 + photo.gain.rgb) * d_seen;
    return vw_appearance(vec4(d_seen * rendered, 0.0), vec4(d_seen, 0.0));
}

// The photos are visited once an epoch, the field at every step: so their numbers move faster, by these multiples of the learning rate. And
// since all gains could rise while the field's colours fall, as could all codes, a ridge keeps them near 0.
const float PHOTO_RATE = 10.0;
const float CODE_RATE = 3.0;
const float PHOTO_RIDGE = 0.01; // gradient of the mean loss per unit of a photo's number
const float FIT_RIDGE = 0.1;    // of fit_views, in squared errors: one ray that is off by 0.3 weighs as much as a gain or bias that is

#endif
