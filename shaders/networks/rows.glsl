// Reading the activation rows of a chunk, through texels where the device's views are large enough.
#ifndef ROWS_GLSL
#define ROWS_GLSL

#ifdef ROWS_OF_GRID
BUFFER(VW_SLOT_GRID_ROWS) readonly buffer GridRows { vec4 grid_rows[]; };
layout(set = 0, binding = VW_SLOT_GRID_ROWS_TEXEL) uniform samplerBuffer grid_rows_texel;

vec4 grid_row(uint row, uint slot) {
    uint place = VW_ROW_PLACE(GRID_ROW_COUNT, row, slot);
    return ROWS_TEXEL != 0u ? texelFetch(grid_rows_texel, int(place)) : grid_rows[place];
}
#else
#include "bfloat.glsl"
BUFFER(VW_SLOT_ROWS) readonly buffer Rows { uvec2 rows[]; };
layout(set = 0, binding = VW_SLOT_ROWS_TEXEL) uniform usamplerBuffer rows_texel;

uint row_place(uint row, uint slot) { return VW_ROW_PLACE(ROW_COUNT, row, slot); }
vec4 row_at(uint place) {
    return unpack_bfloats(ROWS_TEXEL != 0u ? texelFetch(rows_texel, int(place)).xy : rows[place]);
}
#endif

#endif
