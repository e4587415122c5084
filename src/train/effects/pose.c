#include "train/effects/pose.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/memory.h"
#include "gpu/shaders.h"

enum vw_status vw_pose_create_buffers(const struct vw_radiance_field *field, uint32_t padded_rays,
                                      struct vw_pose_effect *pose) {
    uint64_t photos = field->model->poses.size_bytes / sizeof(struct vw_pose),
             samples = field->model->specialization.chunk_samples;
    const struct {
        struct vw_buffer **buffer;
        struct vw_buffer_params params;
    } buffers[] = {
        {&pose->moments, {.name = "pose_moments", .size_bytes = sizeof(struct vw_pose_moments) * photos}},
        {&pose->d_positions, {.name = "d_positions", .size_bytes = sizeof(vw_float4) * samples}},
        {&pose->d_poses, {.name = "d_poses", .size_bytes = sizeof(struct vw_pose) * (uint64_t)padded_rays}},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(buffers) && photos && !status; i++)
        status = vw_buffer_create(field->gpu, &buffers[i].params, buffers[i].buffer);
    return status;
}

void vw_pose_bind(const struct vw_radiance_field *field, const struct vw_pose_effect *pose, struct vw_binding *bindings,
                  uint32_t *count) {
    const struct vw_param_range *poses = &field->model->poses;
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_POSES,
                                               .buffer = field->params,
                                               .offset_bytes = poses->offset_bytes,
                                               .size_bytes = poses->size_bytes,
                                               .unused = !poses->size_bytes};
    if (!pose || !pose->moments) return;
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_POSE_MOMENTS, .buffer = pose->moments};
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_D_POSITIONS, .buffer = pose->d_positions};
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_D_POSES, .buffer = pose->d_poses};
}

enum vw_status vw_pose_create_passes(const struct vw_radiance_field *field, const struct vw_binding *bindings,
                                     uint32_t count, struct vw_pose_effect *pose) {
    const struct {
        const struct vw_shader *shader;
        struct vw_pass **pass;
    } passes[] = {
        {field->model->half_grid ? &vw_shader_gradient_positions_half : &vw_shader_gradient_positions,
         &pose->gradient_positions},
        {&vw_shader_gradient_pose, &pose->gradient},
        {&vw_shader_update_pose, &pose->update},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(passes) && pose->moments && !status; i++) {
        struct vw_pass_params params = {.shader = passes[i].shader,
                                        .specialization = (const uint32_t *)&field->model->specialization,
                                        .specialization_count = VW_SPECIALIZATION_COUNT,
                                        .bindings = bindings,
                                        .binding_count = count};
        status = vw_pass_create(field->gpu, &params, passes[i].pass);
    }
    return status;
}

void vw_pose_destroy(struct vw_pose_effect *pose) {
    vw_pass_destroy(&pose->gradient_positions);
    vw_pass_destroy(&pose->gradient);
    vw_pass_destroy(&pose->update);
    vw_buffer_destroy(&pose->moments);
    vw_buffer_destroy(&pose->d_positions);
    vw_buffer_destroy(&pose->d_poses);
}

void vw_pose_training_state(const struct vw_pose_effect *pose, struct vw_buffer **buffers, uint32_t *count) {
    if (pose->moments) buffers[(*count)++] = pose->moments;
}

void vw_pose_record_chunk(const struct vw_pose_effect *pose, const struct vw_model *model, struct vw_submission *batch,
                          const struct vw_field_chunk *chunk) {
    uint64_t samples = (uint64_t)chunk->rays->ray_count * model->specialization.samples;
    if (!pose->update) return;
    if (chunk->kept) // as backward_field
        vw_submission_dispatch_indirect(batch, pose->gradient_positions, NULL, 0, chunk->kept,
                                        offsetof(struct vw_kept, field_groups));
    else vw_submission_dispatch(batch, pose->gradient_positions, NULL, 0, samples);
    vw_submission_dispatch(batch, pose->gradient, chunk->rays, sizeof *chunk->rays, chunk->rays->ray_count);
}

void vw_pose_record_update(const struct vw_pose_effect *pose, struct vw_submission *batch, struct vw_push_update push,
                           uint32_t padded_rays) {
    push.count = padded_rays;
    if (pose->update) vw_submission_dispatch(batch, pose->update, &push, sizeof push, 1);
}

static double length_of(vw_float4 v) { return sqrt((double)v.x * v.x + (double)v.y * v.y + (double)v.z * v.z); }

// Turns as shaders/effects/pose.glsl has them.
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
    const struct vw_param_range *range = &field->model->poses;
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
