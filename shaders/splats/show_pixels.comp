// Copies a drawing to the pixels that an evaluator looks at: their colours over the backdrop, and what is left of the
// light. Not numbers where the drawing had no room, so that validation says so. Variant `depth`: without the backdrop.
#define SEES_SKY
#include "effects/seen.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_BLENDED) readonly buffer Blended { vec4 blended[]; };
BUFFER(VW_SLOT_SHOWN) readonly buffer Shown { uvec2 shown[]; };
BUFFER(VW_SLOT_SPLAT_STATE) readonly buffer SplatState { vw_splat_state splat_state; };
BUFFER(VW_SLOT_COLOURS) writeonly buffer Colours { vec4 colours[]; };
PUSH uniform Push { vw_push_shown push; };

void main() {
    uint index = invocation_index();
    if (index >= push.count) return;
    uvec2 place = shown[push.first + index];
    vec4 drawn = blended[place.y];
#ifdef VW_DEPTH
    vec3 colour = drawn.rgb;
#else
    vec3 colour = drawn.rgb + drawn.a * backdrop_colour(rays[place.x], place.x, uvec4(0u));
#endif
    vec4 missing = vec4(uintBitsToFloat(0x7FC00000u));
    colours[place.x] = mix(vec4(colour, drawn.a), missing, bvec4(splat_state.overflow != 0u));
}
