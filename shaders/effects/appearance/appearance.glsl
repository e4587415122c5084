// A photo's own exposure and white balance: a gain and a bias per channel (as in Urban Radiance Fields, Rematas et al.,
// CVPR 2022, of whose affine map this is the diagonal). Training corrects photos by theirs. Validation fits one to each
// view, and applies it to what is rendered.
#ifndef APPEARANCE_GLSL
#define APPEARANCE_GLSL

// Applies gain and bias. A gain is stored minus 1, so that numbers of 0 leave colours bit-identical, and a ridge pulls
// to the identity.
vec3 appear(vw_appearance photo, vec3 colour) { return (1.0 + photo.gain.rgb) * colour + photo.bias.rgb; }

// Undoes that, within the colours that a field can render: the sky of a dark photo would be brighter. Where
// all are 0, colours stay bit-identical.
vec3 correct(vw_appearance photo, vec3 shown) {
    vec3 corrected = (shown - photo.bias.rgb) / (1.0 + photo.gain.rgb);
    if (finite(vec4(corrected, 0.0))) corrected = clamp(corrected, 0.0, 1.0); // else the step is skipped
    return corrected;
}

#endif
