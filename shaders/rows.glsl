// Reading the activation rows of a chunk, through texels where the device's views are large enough.
#ifndef ROWS_GLSL
#define ROWS_GLSL

BUFFER(VW_SLOT_ROWS) readonly buffer Rows { vec4 rows[]; };
layout(set = 0, binding = VW_SLOT_ROWS_TEXEL) uniform samplerBuffer rows_texel;

uint row_place(uint row, uint slot) { return VW_ROW_PLACE(ROW_COUNT, row, slot); }
vec4 row_at(uint place) { return ROWS_TEXEL != 0u ? texelFetch(rows_texel, int(place)) : rows[place]; }
vec4 row_value(uint row, uint slot) { return row_at(row_place(row, slot)); }

#endif
