// Computes the force on the photo's camera by one ray per invocation, the sum of the gradients by its samples'
// positions, and the torque about it. Samples move with the ray: their places on it are fixed, and so are the lengths
// that they represent.
#include "networks/mlp.glsl"
#define ROWS_OF_GRID
#include "networks/rows.glsl"
#include "effects/pose/pose.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_CAMERAS) readonly buffer Cameras { vw_gpu_camera cameras[]; };
BUFFER(VW_SLOT_POSES) readonly buffer Poses { vw_pose poses[]; };
BUFFER(VW_SLOT_D_POSITIONS) readonly buffer DPositions { vec4 d_positions[]; };
BUFFER(VW_SLOT_D_POSES) writeonly buffer DPoses { vw_pose d_poses[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_samples push; };

void main() {
    uint index = invocation_index();
    if (index >= push.ray_count) return;
    vec3 place = camera_place(cameras[state.view], poses[state.view]), force = vec3(0.0), torque = vec3(0.0);
    for (uint slot = index * SAMPLES; slot < (index + 1u) * SAMPLES; slot++) {
        vec3 gradient = d_positions[slot].xyz;
        force += gradient;
        torque += cross(grid_row(GRID_ROW_POSITION, slot).xyz - place, gradient);
    }
    d_poses[push.first_ray + index] = vw_pose(vec4(force, 0.0), vec4(torque, 0.0));
}
