// The effect `pose`: a small correction of each training camera, in box coordinates: it is shifted, and turned about
// its own place by 2 atan(|h|) about the axis h (Cayley's form of a rotation, without sines; for small angles 2 h is
// the rotation vector):
//   R v = v + 2 / (1 + |h|^2) (h x v + h x (h x v)),  and when h moves by dh, R v by w x R v with w = 2 / (1 + |h|^2)
//   (dh + h x dh).
// Forward and backward.
#ifndef POSE_GLSL
#define POSE_GLSL

// Converts a photo's turn, in radians, to 2 h. A camera far from the box sees it at a small angle: its turns are in box
// edges, too.
float turn_unit(vw_gpu_camera camera) { return 1.0 / max(1.0, camera.reference.w); }

vec3 turn_by(vec3 h, vec3 v) {
    vec3 across = cross(h, v);
    return 2.0 / (1.0 + dot(h, h)) * (across + cross(h, across));
}

vw_gpu_camera corrected_camera(vw_gpu_camera camera, vw_pose pose) {
    vec3 h = 0.5 * turn_unit(camera) * pose.turn.xyz, by = turn_by(h, camera.back.xyz);
    camera.right.xyz += turn_by(h, camera.right.xyz);
    camera.up.xyz += turn_by(h, camera.up.xyz);
    camera.back.xyz += by;
    camera.reference.xyz += pose.shift.xyz - camera.reference.w * by; // which is that much before the camera itself
    return camera;
}

// Returns the position of the corrected camera.
vec3 camera_place(vw_gpu_camera camera, vw_pose pose) {
    return camera.reference.xyz + camera.reference.w * camera.back.xyz + pose.shift.xyz;
}

// Converts the torque about the corrected camera's place, the sum of (position - place) x (gradient by the position),
// to the gradient by its turn.
vec3 turn_gradient(vw_gpu_camera camera, vw_pose pose, vec3 torque) {
    float unit = turn_unit(camera);
    vec3 h = 0.5 * unit * pose.turn.xyz;
    return unit / (1.0 + dot(h, h)) * (torque - cross(h, torque));
}

// Until the field has come that far, no camera moves.
const uint POSE_WARM_UP = 32u; // steps
// Times the learning rate.
const float POSE_RATE = 0.5;
float pose_rate(uint visits) { return POSE_RATE * inversesqrt(float(visits)); }
const float POSE_RIDGE = 0.01;

#endif
