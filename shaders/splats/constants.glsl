// The specialization constants that passes of splats have beside those of a run.
#ifndef SPLAT_CONSTANTS_GLSL
#define SPLAT_CONSTANTS_GLSL

VW_SPLAT_SPECIALIZATION(VW_DECLARE_CONSTANT)

#endif
