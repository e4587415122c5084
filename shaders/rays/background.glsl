// The colour seen through transparent pixels, and through the field if the scene has no sky: the scene's own colour, or
// in training one drawn for each ray and step. Because this colour changes, a field cannot hide floating matter in
// empty space by painting it in the background's colour.
#ifndef BACKGROUND_GLSL
#define BACKGROUND_GLSL
#include "random.glsl"

vec3 background_colour(uint ray, uvec4 key) {
    // No ?: here: glslang makes it a constant select by a scalar, of which Mesa 22.3 folds only the first component.
    if (EFFECT_BACKGROUND == BACKGROUND_NONE) return vec3(0.0);
    if (EFFECT_BACKGROUND == BACKGROUND_RANDOM && TRAINING != 0u) {
        uvec4 words = random_words(RANDOM_BACKGROUND, key, ray, 0u);
        return vec3(random_unit(words.x), random_unit(words.y), random_unit(words.z));
    }
    return vec3(BACKGROUND_RED, BACKGROUND_GREEN, BACKGROUND_BLUE);
}

#endif
