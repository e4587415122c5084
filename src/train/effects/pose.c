// The effect `pose`: a small correction of each training camera, a shift and a turn, all 0 at first
// (shaders/effects/pose/pose.glsl).
//   generate_rays: rays of the corrected camera -> ... -> gradient_positions: from the gradients by samples' encodings
//   to those by their positions -> gradient_pose: force and torque of each ray -> update_pose: the photo's correction,
//   lazily
// Only training uses it: validation and rendering see all cameras as the scene has them. It needs the field hash, whose
// encoding has a gradient by the position, and a box.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/effects.h"
#include "train/field.h"
#include "train/fields/registry.h"
#include "train/trainer.h"

enum { POSITIONS, GRADIENT };

static void lay_out_ranges(struct vw_model *model, uint64_t trained_views) {
    vw_model_append_range(model, VW_SLOT_POSES, sizeof(struct vw_pose) * (uint64_t)model->view_count,
                          6 * trained_views);
}

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    uint64_t samples = model->specialization.chunk_samples, rays = padded_rays, photos = model->view_count;
    const struct vw_effect_buffer listed[] = {
        {VW_SLOT_POSE_MOMENTS, "pose_moments", sizeof(struct vw_pose_moments) * photos, VW_EFFECT_CARRIED},
        {VW_SLOT_D_POSITIONS, "d_positions", sizeof(vw_float4) * samples, VW_EFFECT_OF_STEP},
        {VW_SLOT_D_POSES, "d_poses", sizeof(struct vw_pose) * rays, VW_EFFECT_OF_STEP},
    };
    memcpy(buffers, listed, sizeof listed);
    return VW_ARRAY_COUNT(listed);
}

static void record_chunk_gradient(const struct vw_model *model, struct vw_pass *const *passes,
                                  struct vw_submission *submission, const struct vw_push_samples *chunk) {
    uint64_t samples = (uint64_t)chunk->ray_count * model->specialization.samples;
    vw_submission_dispatch(submission, passes[POSITIONS], NULL, 0, samples);
    vw_submission_dispatch(submission, passes[GRADIENT], chunk, sizeof *chunk, chunk->ray_count);
}

const struct vw_effect_kind vw_effect_pose = {
    .name = "pose",
    .constant = VW_EFFECT_CONSTANT(pose),
    .adjoint = VW_ADJOINT_REFUSES, // it does not know how cameras move
    .training_alone = true,
    .shaders = {[POSITIONS] = &vw_shader_gradient_positions, [GRADIENT] = &vw_shader_gradient_pose},
    .update = &vw_shader_update_pose,
    .ranges = {VW_SLOT_POSES},
    .lay_out_ranges = lay_out_ranges,
    .list_buffers = list_buffers,
    .record_chunk_gradient = record_chunk_gradient,
};

// ---- Measurement ----------------------------------------------------------------------------------------------------

static double length_of(vw_float4 v) { return sqrt((double)v.x * v.x + (double)v.y * v.y + (double)v.z * v.z); }

// Turns as shaders/effects/pose/pose.glsl has them.
static void add_correction(const struct vw_gpu_camera *camera, const struct vw_pose *pose, double share,
                           struct vw_camera_corrections *sum) {
    double unit = 1.0 / fmax(1.0, camera->reference.w), edges = length_of(pose->shift),
           deg = 2.0 * atan(0.5 * unit * length_of(pose->turn)) * 180.0 / M_PI;
    sum->mean_edges += share * edges;
    sum->mean_deg += share * deg;
    sum->largest_edges = fmax(sum->largest_edges, edges);
    sum->largest_deg = fmax(sum->largest_deg, deg);
}

enum vw_status vw_pose_measure(const struct vw_radiance_field *field, const uint32_t *views, uint32_t count,
                               struct vw_camera_corrections *corrections) {
    const struct vw_param_range *range = &field->model->ranges[VW_SLOT_POSES];
    uint64_t cameras_bytes = vw_buffer_size_bytes(field->cameras);
    *corrections = (struct vw_camera_corrections){0};
    if (!range->size_bytes) return VW_OK;
    struct vw_pose *poses = vw_allocate(1, range->size_bytes);
    struct vw_gpu_camera *cameras = vw_allocate(1, cameras_bytes);
    enum vw_status status = poses && cameras ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = vw_buffer_read(field->params, range->offset_bytes, poses, range->size_bytes);
    if (!status) status = vw_buffer_read(field->cameras, 0, cameras, cameras_bytes);
    for (uint32_t i = 0; i < count && !status; i++)
        add_correction(&cameras[views[i]], &poses[views[i]], 1.0 / count, corrections);
    free(poses);
    free(cameras);
    return status;
}
