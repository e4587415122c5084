// Moves the correction of the step's camera (photo_adam.glsl). One workgroup, which sums what the rays say in a fixed
// order: each invocation every 64th, then the first the 64 sums.
#include "networks/photo_adam.glsl"
#include "effects/pose/pose.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_CAMERAS) readonly buffer Cameras { vw_gpu_camera cameras[]; };
BUFFER(VW_SLOT_POSES) buffer Poses { vw_pose poses[]; };
BUFFER(VW_SLOT_POSE_MOMENTS) buffer Moments { vw_pose_moments moments[]; };
BUFFER(VW_SLOT_D_POSES) readonly buffer DPoses { vw_pose d_poses[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };

shared vec4 forces[64], torques[64];

void main() {
    uint lane = gl_LocalInvocationID.x;
    vec4 force = vec4(0.0), torque = vec4(0.0);
    for (uint i = lane; i < push.count; i += 64u) {
        force += d_poses[i].shift;
        torque += d_poses[i].turn;
    }
    forces[lane] = force;
    torques[lane] = torque;
    barrier();
    if (lane != 0u || state.nonfinite != 0u || push.step_low <= POSE_WARM_UP) return; // nonfinite: the step is skipped
    for (uint i = 1u; i < 64u; i++) {
        force += forces[i];
        torque += torques[i];
    }
    vw_pose pose = poses[state.view];
    vw_pose_moments moment = moments[state.view];
    moment.visits = next_visit(moment.visits);
    vec4 d_shift = force * INVERSE_RAYS + POSE_RIDGE * pose.shift;
    vec4 d_turn =
        vec4(turn_gradient(cameras[state.view], pose, torque.xyz), 0.0) * INVERSE_RAYS + POSE_RIDGE * pose.turn;
    float rate = pose_rate(moment.visits);
    pose.shift -= photo_step(rate, d_shift, moment.visits, moment.shift1, moment.shift2);
    pose.turn -= photo_step(rate, d_turn, moment.visits, moment.turn1, moment.turn2);
    if (!stays_finite(finite(pose.shift) && finite(pose.turn))) return;
    poses[state.view] = pose;
    moments[state.view] = moment;
}
