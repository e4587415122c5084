// All codes of photos could drift, where the code 0 of rendering is unknown: a ridge pulls them to 0. Gradient of the
// mean loss per unit.
#ifndef PHOTO_RIDGE_GLSL
#define PHOTO_RIDGE_GLSL

const float PHOTO_RIDGE = 0.01;

#endif
