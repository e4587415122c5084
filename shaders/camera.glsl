// From an image position to a ray in box coordinates, with radial and tangential distortion undone.
// Model and axes: struct vw_camera in include/viewworth/scene.h; vw_gpu_camera in interface.h.
#ifndef CAMERA_GLSL
#define CAMERA_GLSL

// OpenCV's model: the distorted position of an undistorted one (image plane at z = 1, y down). distortion: k1, k2, p1, p2.
vec2 distort(vec2 p, vec4 distortion) {
    float r2 = dot(p, p);
    float radial = 1.0 + r2 * (distortion.x + r2 * distortion.y);
    return p * radial + 2.0 * p.x * p.y * distortion.zw + distortion.wz * (r2 + 2.0 * p * p);
}

// Newton's method on distort(p) = target, from p = target.
vec2 undistort(vec2 target, vec4 distortion) {
    vec2 p = target;
    for (int i = 0; i < 8; i++) {
        float r2 = dot(p, p);
        float radial = 1.0 + r2 * (distortion.x + r2 * distortion.y);
        float radial_slope = 2.0 * distortion.x + 4.0 * distortion.y * r2; // d radial / d p = slope * p
        float cross_term = radial_slope * p.x * p.y + 2.0 * dot(distortion.zw, p);
        float xx = radial + radial_slope * p.x * p.x + 2.0 * distortion.z * p.y + 6.0 * distortion.w * p.x;
        float yy = radial + radial_slope * p.y * p.y + 6.0 * distortion.z * p.y + 2.0 * distortion.w * p.x;
        vec2 miss = distort(p, distortion) - target;
        float determinant = xx * yy - cross_term * cross_term;
        // Beyond the fold of the model there is no inverse: stay where the Jacobian was last regular.
        if (determinant > 1e-4) p -= vec2(yy * miss.x - cross_term * miss.y, xx * miss.y - cross_term * miss.x) / determinant;
    }
    return p;
}

// The strata of a ray in the unit cube: near edge (w of origin) and stride (w of direction). A ray that misses has stride 0.
// `camera_parameter` is where the camera lies on the ray: nothing behind it is seen, nor within NEAR_EDGES of it.
const float NEAR_EDGES = 0.02; // box edges; keeps blobs from growing on the lenses of cameras inside the box

vw_ray box_ray(vec3 origin, vec3 direction, float camera_parameter) {
    // A zero component becomes tiny, so that parallel rays divide to huge finite values and never to 0/0.
    vec3 safe = mix(direction, vec3(1e-12), lessThan(abs(direction), vec3(1e-12)));
    vec3 first = (vec3(0.0) - origin) / safe;
    vec3 second = (vec3(1.0) - origin) / safe;
    vec3 entry = min(first, second);
    vec3 leave = max(first, second);
    float near = max(max(entry.x, max(entry.y, entry.z)), camera_parameter + NEAR_EDGES);
    float far = min(leave.x, min(leave.y, leave.z));
    vw_ray ray;
    ray.origin_near = vec4(origin, near);
    ray.direction_stride = vec4(direction, max(far - near, 0.0) / float(SAMPLES));
    ray.target_weight = vec4(0.0);
    return ray;
}

vw_ray camera_ray(vw_gpu_camera camera, vec2 position_px) {
    vec2 focal = vec2(camera.right.w, camera.up.w);
    vec2 centre = vec2(camera.back.w, camera.more.x);
    vec2 p = (position_px - centre) / focal;
    if (EFFECT_DISTORTION != 0u) p = undistort(p, camera.distortion);
    p.y = -p.y; // OpenCV's y runs down, the camera's up
    vec3 offset = camera.right.xyz * p.x + camera.up.xyz * p.y;
    float stretch = sqrt(1.0 + dot(p, p)); // |(x, y, -1)|
    float depth = camera.reference.w;
    return box_ray(camera.reference.xyz + depth * offset, (offset - camera.back.xyz) / stretch, -depth * stretch);
}

#endif
