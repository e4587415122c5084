// The specialization constants that passes of splats have beside those of a run.
#ifndef SPLAT_CONSTANTS_GLSL
#define SPLAT_CONSTANTS_GLSL

VW_SPLAT_SPECIALIZATION(VW_DECLARE_CONSTANT)

const float SPLAT_NEAR = 0.02; // box edges from the camera to the nearest splat that it shows

#endif
