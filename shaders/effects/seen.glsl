// The colour seen at a ray, over a background or sky; forward and backward. The sky, and what fit_photo needs, are in
// variants VW_RAY_EFFECTS, since some devices cannot bind their buffers in addition.
#ifndef SEEN_GLSL
#define SEEN_GLSL
#include "rays/background.glsl"
#ifdef VW_RAY_EFFECTS
#define SEES_SKY
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

#ifdef SEES_BACK // to the sky; and keeps what fit_photo needs of a ray
#ifdef VW_RAY_EFFECTS
BUFFER(VW_SLOT_D_SKY) writeonly buffer DSky { vec4 d_sky[]; };
BUFFER(VW_SLOT_RENDERED) writeonly buffer Rendered { vec4 rendered[]; };

void seen_back(uint ray_index, vec3 seen, float weight, vec3 backdrop, float left, vec3 d_seen) {
    if (EFFECT_APPEARANCE == APPEARANCE_FITTED) rendered[ray_index] = vec4(seen, weight);
    if (EFFECT_SKY != 0u) d_sky[ray_index] = vec4(sky_gradient(backdrop, left, d_seen), 0.0);
}
#else
#define seen_back(ray_index, seen, weight, backdrop, left, d_seen)
#endif
#endif

#endif
