// One pixel and one splat: how much of its colour is added, front to back; forward and backward by the same function.
#ifndef BLENDING_GLSL
#define BLENDING_GLSL
#include "splats/constants.glsl"

const float ALPHA_LEAST = 1.0 / 255.0;
const float ALPHA_MOST = 0.99;
const float LEFT_LEAST = 1e-4; // less must not be left: the splat that would leave less ends the pixel
const float LOG2_E = 1.4426950408889634;

// A tile's pixels are shared by SPLAT_LANES invocations: each has COLUMNS columns of ROWS pixels.
const uint COLUMNS = (SPLAT_SIDE + SPLAT_LANES - 1u) / SPLAT_LANES;
const uint ROWS = SPLAT_SIDE * SPLAT_SIDE / SPLAT_LANES / COLUMNS;
const uint ROW_STEP = (SPLAT_LANES + SPLAT_SIDE - 1u) / SPLAT_SIDE;
const uint PIXELS = COLUMNS * ROWS;

uvec2 lane_pixel(uint lane) { return uvec2(lane % SPLAT_SIDE, lane / SPLAT_SIDE); }
uint pixel_x(uint first, uint column) { return first + column * SPLAT_LANES; }
uint pixel_y(uint first, uint row) { return first + row * ROW_STEP; }

struct blended {
    float raw;    // opacity times Gaussian
    float alpha;  // share that it covers of the light left
    float weight; // weight of its colour; 0 where it does not count
};

// Blends one splat. `left` is the light that the splats before left; minus that once the pixel has ended. `power` is
// minus the exponent, to base 2.
blended blend(float power, float opacity, inout float left) {
    precise blended b;
    b.raw = opacity * exp2(power);
    b.alpha = min(b.raw, ALPHA_MOST);
    precise float weight = left * b.alpha;
    precise float next = left - weight;
    bool drawn = b.raw >= ALPHA_LEAST, more = next > LEFT_LEAST;
    float ended = -abs(left);
    float after = mix(ended, next, more);
    left = mix(left, after, drawn);
    b.weight = mix(0.0, weight, drawn && more);
    return b;
}

// Minus the exponent at (dx, dy), to base 2, is a + dy (b + c dy). Rounding can leave a needle more than 0.
float power_at(vec3 terms, float dy) {
    precise float power = terms.x + dy * (terms.y + terms.z * dy);
    return mix(power, 0.0, power > 0.0);
}

vec3 power_terms(vec3 conic, float dx) {
    precise vec3 terms = vec3(-0.5 * LOG2_E * conic.x * dx * dx, -LOG2_E * conic.y * dx, -0.5 * LOG2_E * conic.z);
    return terms;
}

#endif
