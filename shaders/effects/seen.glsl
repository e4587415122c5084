// The colour seen at a ray: over a background or sky, and as the step's photo shows it; forward and backward. Sky and
// appearance are in variants VW_RAY_EFFECTS, since some devices cannot bind their buffers in addition.
#ifndef SEEN_GLSL
#define SEEN_GLSL
#include "rays/background.glsl"
#ifdef VW_RAY_EFFECTS
#define SEES_SKY
#include "effects/appearance/appearance.glsl"
BUFFER(VW_SLOT_APPEARANCE) readonly buffer Appearance { vw_appearance appearance[]; };
#endif
#ifdef SEES_SKY
#include "effects/sky/sky.glsl"
#endif

vec3 backdrop_colour(vw_ray ray, uint ray_index, uvec4 key) {
#ifdef SEES_SKY
    if (EFFECT_SKY != 0u) return sky_colour(ray.direction_stride.xyz);
#endif
    return background_colour(ray_index, key);
}

#ifdef VW_RAY_EFFECTS
vec3 seen_by_photo(uint view, vec3 rendered) {
    if (EFFECT_APPEARANCE != 0u) return appear(appearance[view], rendered);
    return rendered;
}
#else
#define seen_by_photo(view, rendered) (rendered)
#endif

#ifdef SEES_BACK // from the gradient by what is seen to that by what was rendered, to the photo's numbers and to the
                 // sky
#ifdef VW_RAY_EFFECTS
BUFFER(VW_SLOT_D_SKY) writeonly buffer DSky { vec4 d_sky[]; };
BUFFER(VW_SLOT_D_APPEARANCE) writeonly buffer DAppearance { vw_appearance d_appearance[]; };

void seen_back(uint ray_index, uint view, vec3 rendered, vec3 backdrop, float left, inout vec3 d_colour) {
    if (EFFECT_APPEARANCE != 0u) {
        vec3 d_seen = d_colour;
        d_appearance[ray_index] = appear_back(appearance[view], rendered, d_seen, d_colour);
    }
    if (EFFECT_SKY != 0u) d_sky[ray_index] = vec4(sky_gradient(backdrop, left, d_colour), 0.0);
}
#else
#define seen_back(ray_index, view, rendered, backdrop, left, d_colour)
#endif
#endif

#endif
