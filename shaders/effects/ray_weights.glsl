// Weights of rays in the loss: how visible they are, or how certain, for passes that take the loss.
#ifndef RAY_WEIGHTS_GLSL
#define RAY_WEIGHTS_GLSL
#include "effects/visibility/visibility.glsl"

BUFFER(VW_SLOT_VISIBILITY) buffer RayWeights { vec2 ray_weights[]; };

const float CERTAIN_LEAST = 1e-30; // below, the cost of doubt rises no more

// Returns the loss up to which a pixel counts wholly: that of an error of BETA_MIN in all channels, but at first of the
// size weight of visibility, since the field has not learned anything yet. (The published code lets beta count slowly.)
float certain_loss(uvec4 key) {
    float value, slope;
    loss_channel(sqrt(max(BETA_MIN * BETA_MIN, early_square(key))), value, slope);
    return value;
}

bool rays_are_weighed() { return EFFECT_VISIBILITY != 0u || EFFECT_UNCERTAINTY != 0u; }

float ray_weight(uint ray) { return ray_weights[ray].x; }

// Returns the loss of a ray of this weight, with what the weight costs, and leaves the gradient by the weight. `loss`
// is the ray's own, of a pixel of `pixel_weight`.
float weigh_ray(uint ray, float loss, float pixel_weight, uvec4 key) {
    float weight = ray_weight(ray), cost, d_cost;
    if (EFFECT_UNCERTAINTY != 0u) {
        float by_doubt = pixel_weight * certain_loss(key), certain = max(weight, CERTAIN_LEAST);
        cost = -by_doubt * log(certain);
        d_cost = -by_doubt / certain;
    } else {
        float hidden = 1.0 - weight, by_size = pixel_weight * size_weight(key);
        cost = by_size * hidden * hidden;
        d_cost = -2.0 * by_size * hidden;
    }
    ray_weights[ray].y = loss + d_cost;
    return weight * loss + cost;
}

#endif
