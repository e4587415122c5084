// Rays in box coordinates of image positions, the lens undone.
// Model and axes: struct vw_camera in include/viewworth/scene.h; vw_gpu_camera in interface.h.
#ifndef CAMERA_GLSL
#define CAMERA_GLSL

// Returns the radial factor of a polynomial lens (x) and its slope (y): d factor / d p = slope * p. distortion: k1, k2,
// p1, p2; higher: k3 to k6.
vec2 radial_factor(float r2, vec4 distortion, vec4 higher) {
    if (EFFECT_DISTORTION == DISTORTION_BASIC)
        return vec2(1.0 + r2 * (distortion.x + r2 * distortion.y), 2.0 * distortion.x + 4.0 * distortion.y * r2);
    float above = 1.0 + r2 * (distortion.x + r2 * (distortion.y + r2 * higher.x));
    float below = 1.0 + r2 * (higher.y + r2 * (higher.z + r2 * higher.w));
    float above_slope = 2.0 * distortion.x + r2 * (4.0 * distortion.y + r2 * 6.0 * higher.x);
    float below_slope = 2.0 * higher.y + r2 * (4.0 * higher.z + r2 * 6.0 * higher.w);
    return vec2(above / below, (above_slope - above / below * below_slope) / below);
}

// Distorts a position (image plane at z = 1, y down) whose radial factor is known.
vec2 distort(vec2 p, float radial, vec4 distortion) {
    return p * radial + 2.0 * p.x * p.y * distortion.zw + distortion.wz * (dot(p, p) + 2.0 * p * p);
}

// Newton's method on distort(p) = target, from p = target, with steps halved until they come closer. Strong lenses need
// the many rounds; pixels beyond the fold of the model, which have no inverse, are masked by the host
// (src/scene/photo.c).
const int UNDISTORT_ROUNDS = 32;

vec2 undistort(vec2 target, vec4 distortion, vec4 higher) {
    vec2 p = target;
    vec2 miss = distort(p, radial_factor(dot(p, p), distortion, higher).x, distortion) - target;
    float share = 1.0; // share of Newton's step
    for (int i = 0; i < UNDISTORT_ROUNDS; i++) {
        vec2 radial = radial_factor(dot(p, p), distortion, higher);
        float cross_term = radial.y * p.x * p.y + 2.0 * dot(distortion.zw, p);
        float xx = radial.x + radial.y * p.x * p.x + 2.0 * distortion.z * p.y + 6.0 * distortion.w * p.x;
        float yy = radial.x + radial.y * p.y * p.y + 6.0 * distortion.z * p.y + 2.0 * distortion.w * p.x;
        float determinant = xx * yy - cross_term * cross_term;
        vec2 newton =
            vec2(yy * miss.x - cross_term * miss.y, xx * miss.y - cross_term * miss.x) / max(determinant, 1e-4);
        vec2 next = p - share * newton;
        vec2 next_miss = distort(next, radial_factor(dot(next, next), distortion, higher).x, distortion) - target;
        bool closer = dot(next_miss, next_miss) < dot(miss, miss);
        p = closer ? next : p;
        miss = closer ? next_miss : miss;
        share = closer ? min(1.0, 2.0 * share) : 0.5 * share;
    }
    return p;
}

// Newton's method on the angle off the axis, from the angle that it would be without coefficients.
const float FISHEYE_ANGLE_MAX = 1.55; // radians: short of a right angle, where directions (x, y, -1) end

vec2 undistort_fisheye(vec2 target, vec4 distortion, vec4 higher) {
    float distorted = length(target);
    float angle = min(distorted, FISHEYE_ANGLE_MAX);
    for (int i = 0; i < 8; i++) {
        float a2 = angle * angle;
        float slope =
            1.0 + a2 * (3.0 * distortion.x + a2 * (5.0 * distortion.y + a2 * (7.0 * higher.x + a2 * 9.0 * higher.y)));
        float miss =
            angle * (1.0 + a2 * (distortion.x + a2 * (distortion.y + a2 * (higher.x + a2 * higher.y)))) - distorted;
        if (slope > 1e-2) angle = clamp(angle - miss / slope, 0.0, FISHEYE_ANGLE_MAX); // else beyond the fold, as above
    }
    return distorted > 0.0 ? target * (tan(angle) / distorted) : target;
}

// Undistorts the position (y down) that a camera sees, in units of its focal lengths.
vec2 undo_lens(vw_gpu_camera camera, vec2 target) {
    if (EFFECT_DISTORTION == DISTORTION_NONE) return target;
    bool fisheye = EFFECT_DISTORTION == DISTORTION_ANY_LENS && camera.more.w != 0.0;
    if (fisheye) return undistort_fisheye(target, camera.distortion, camera.higher);
    return undistort(target, camera.distortion, camera.higher);
}

// Computes the strata of a ray in the unit cube: near edge (w of origin) and stride (w of direction). A ray that misses
// has stride 0. The ray sees only what lies between the ray parameters of `limits`.
vw_ray box_ray(vec3 origin, vec3 direction, vec2 limits) {
    // A zero component becomes tiny, so that parallel rays divide to huge finite values and never to 0/0.
    vec3 safe = mix(direction, vec3(1e-12), lessThan(abs(direction), vec3(1e-12)));
    vec3 first = (vec3(0.0) - origin) / safe;
    vec3 second = (vec3(1.0) - origin) / safe;
    vec3 entry = min(first, second);
    vec3 leave = max(first, second);
    precise float near = max(max(entry.x, max(entry.y, entry.z)), limits.x);
    precise float far = min(min(leave.x, min(leave.y, leave.z)), limits.y);
    vw_ray ray;
    ray.origin_near = vec4(origin, near);
    ray.direction_stride = vec4(direction, max(far - near, 0.0) / float(STRATA));
    ray.target_weight = vec4(0.0);
    return ray;
}

// Nothing behind the camera is seen, nor within NEAR_EDGES of it; nor what lies outside the depths that its view is
// known to show.
const float NEAR_EDGES = 0.02; // box edges; keeps blobs from growing on the lenses of cameras inside the box
const float FAR_EDGES = 1e30;

vec2 ray_limits(vw_gpu_camera camera, float segment) {
    vec2 limits = vec2(NEAR_EDGES - camera.reference.w * segment, FAR_EDGES);
    if (camera.more.y >= camera.more.z) return limits;
    return vec2(max(limits.x, camera.more.y * segment), camera.more.z * segment);
}

// Makes a ray that no box ends: it runs from the near to the far depth of its camera, see vw_ray.
vw_ray unbounded_ray(vw_gpu_camera camera, vec3 origin, vec3 direction, float segment) {
    vw_ray ray;
    float near = camera.more.y;
    ray.origin_near = vec4(origin + (near - camera.reference.w) * segment * direction, near * segment);
    ray.direction_stride = vec4(direction, camera.more.z * segment);
    ray.target_weight = vec4(0.0);
    return ray;
}

vw_ray camera_ray(vw_gpu_camera camera, vec2 position_px) {
    vec2 focal = vec2(camera.right.w, camera.up.w);
    vec2 centre = vec2(camera.back.w, camera.more.x);
    vec2 p = undo_lens(camera, (position_px - centre) / focal);
    p.y = -p.y;                                                         // OpenCV's y runs down, the camera's up
    precise vec3 offset = camera.right.xyz * p.x + camera.up.xyz * p.y; // training and validation make the same rays
    precise float segment = sqrt(1.0 + dot(p, p));                      // |(x, y, -1)|
    float depth = camera.reference.w;
    precise vec3 origin = camera.reference.xyz + depth * offset, direction = (offset - camera.back.xyz) / segment;
    if (EFFECT_UNBOUNDED != 0u) return unbounded_ray(camera, origin, direction, segment);
    return box_ray(origin, direction, ray_limits(camera, segment));
}

#endif
