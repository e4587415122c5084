#version 460
#extension GL_GOOGLE_include_directive : require
// Params on the line through those before a step and those behind it, on which the measures' slope is taken (--first-order). Four per
// invocation.
#include "common.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_PARAMS_BEFORE) readonly buffer Before { vec4 params_before[]; };
BUFFER(VW_SLOT_PARAMS_AFTER) readonly buffer After { vec4 params_after[]; };
BUFFER(VW_SLOT_PARAMS) writeonly buffer Params { vec4 params[]; };
PUSH uniform Push { vw_push_mix push; };

void main() {
    uint index = invocation_index();
    if (index >= push.count) return;
    params[index] = params_before[index] + push.reach * (params_after[index] - params_before[index]);
}
