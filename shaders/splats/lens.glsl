// The way a lens distorts a position (x / z, y / z; y down), with first and second derivatives: what the rays undo
// (rays/camera.glsl). Both lens models are gradients of a potential, so that all derivatives are symmetric.
#ifndef SPLATS_LENS_GLSL
#define SPLATS_LENS_GLSL
#include "rays/camera.glsl"

const float FISHEYE_SERIES = 1.0 / 256.0; // squared radius below which the fisheye's terms are a series: floats cancel

struct lens_point {
    vec2 at;
    vec3 slopes; // by positions: xx, xy, yy
    vec4 bends;  // second derivatives: xxx, xxy, xyy, yyy
};

// Returns the radial factor, q with d factor / d p = q p, and h with d q / d p = h p.
vec3 polynomial_terms(float r2, vec4 distortion, vec4 higher) {
    vec2 factor = radial_factor(r2, distortion, higher);
    if (EFFECT_DISTORTION == DISTORTION_BASIC) return vec3(factor, 8.0 * distortion.y);
    float below = 1.0 + r2 * (higher.y + r2 * (higher.z + r2 * higher.w));
    float below_slope = higher.y + r2 * (2.0 * higher.z + r2 * 3.0 * higher.w);
    float bend = 2.0 * distortion.y + 6.0 * higher.x * r2 - factor.y * below_slope -
                 factor.x * (2.0 * higher.z + 6.0 * higher.w * r2);
    return vec3(factor, 4.0 * bend / below);
}

vec3 fisheye_terms(float r2, vec4 distortion, vec4 higher) {
    float first = distortion.x - 1.0 / 3.0, second = 0.2 - distortion.x + distortion.y;
    if (r2 < FISHEYE_SERIES)
        return vec3(1.0 + r2 * (first + r2 * second), 2.0 * first + 4.0 * second * r2, 8.0 * second);
    float r = sqrt(r2), angle = atan(r), a2 = angle * angle, by_r = 1.0 / (1.0 + r2); // by_r: d angle / d r
    float factor = angle / r * (1.0 + a2 * (distortion.x + a2 * (distortion.y + a2 * (higher.x + a2 * higher.y))));
    float slope =
        1.0 + a2 * (3.0 * distortion.x + a2 * (5.0 * distortion.y + a2 * (7.0 * higher.x + a2 * 9.0 * higher.y)));
    float bend =
        angle * (6.0 * distortion.x + a2 * (20.0 * distortion.y + a2 * (42.0 * higher.x + a2 * 72.0 * higher.y)));
    float q = (slope * by_r - factor) / r2;
    return vec3(factor, q, ((bend / r - 2.0 * slope) * by_r * by_r - 3.0 * q) / r2);
}

lens_point distort_point(vw_gpu_camera camera, vec2 p) {
    if (EFFECT_DISTORTION == DISTORTION_NONE) return lens_point(p, vec3(1.0, 0.0, 1.0), vec4(0.0));
    bool fisheye = EFFECT_DISTORTION == DISTORTION_ANY_LENS && camera.more.w != 0.0;
    vec4 distortion = camera.distortion;
    vec3 terms = fisheye ? fisheye_terms(dot(p, p), distortion, camera.higher)
                         : polynomial_terms(dot(p, p), distortion, camera.higher);
    vec2 sideways = fisheye ? vec2(0.0) : distortion.zw; // p1, p2
    lens_point lens;
    lens.at = distort(p, terms.x, vec4(distortion.xy, sideways));
    lens.slopes = terms.x * vec3(1.0, 0.0, 1.0) + terms.y * vec3(p.x * p.x, p.x * p.y, p.y * p.y) +
                  vec3(2.0 * sideways.x * p.y + 6.0 * sideways.y * p.x, 2.0 * dot(sideways, p),
                       6.0 * sideways.x * p.y + 2.0 * sideways.y * p.x);
    lens.bends = terms.y * vec4(3.0 * p.x, p.y, p.x, 3.0 * p.y) +
                 terms.z * vec4(p.x * p.x * p.x, p.x * p.x * p.y, p.x * p.y * p.y, p.y * p.y * p.y) +
                 vec4(6.0 * sideways.y, 2.0 * sideways.x, 2.0 * sideways.y, 6.0 * sideways.x);
    return lens;
}

// Applies derivatives of a lens (xx, xy, yy).
vec2 lens_times(vec3 slopes, vec2 v) { return vec2(slopes.x * v.x + slopes.y * v.y, slopes.y * v.x + slopes.z * v.y); }

#endif
