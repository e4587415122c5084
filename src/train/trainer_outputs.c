// The outputs of a trainer beside step records: what it trains, its identity, its state and its field as files,
// renders and measurements. Each function hands the parts of the trainer to the file that does the work.
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "train/effects/effects.h"
#include "train/files/training_files.h"
#include "train/identity.h"
#include "train/renderers/splats/splat_file.h"
#include "train/renderers/splats/splats.h"
#include "train/trainer.h"
#include "train/trainer_private.h"
#include "train/validation/measure_views.h"
#include "viewworth/version.h"

// ---- What it trains -------------------------------------------------------------------------------------------------

uint64_t vw_trainer_total_steps(const struct vw_trainer *trainer) {
    return vw_photo_order_total_steps(&trainer->photo_order);
}

uint64_t vw_trainer_epoch_end(const struct vw_trainer *trainer, uint64_t step) {
    return vw_photo_order_epoch_end(&trainer->photo_order, step);
}

const struct vw_effect_decision *vw_trainer_effects(const struct vw_trainer *trainer, uint32_t *count) {
    *count = trainer->effect_count;
    return trainer->effects;
}

const uint32_t *vw_trainer_validation_views(const struct vw_trainer *trainer, uint32_t *count) {
    *count = trainer->validation.view_count;
    return trainer->validation.views;
}

const struct vw_trainer_parts *vw_trainer_get_parts(struct vw_trainer *trainer) { return &trainer->parts; }

void vw_trainer_get_stats(const struct vw_trainer *trainer, struct vw_trainer_stats *stats) {
    *stats = (struct vw_trainer_stats){.param_count = trainer->model.param_count,
                                       .device_bytes = vw_gpu_buffer_bytes(trainer->gpu),
                                       .clamped_count = trainer->clamped_count,
                                       .nonfinite_steps = trainer->nonfinite_steps,
                                       .floored_steps = trainer->floored_steps,
                                       .val_rays = trainer->validation.ray_count};
}

enum vw_status vw_trainer_camera_corrections(const struct vw_trainer *trainer,
                                             struct vw_camera_corrections *corrections) {
    const struct vw_photo_order *photo_order = &trainer->photo_order;
    return vw_pose_measure(&trainer->field, photo_order->train_views, photo_order->train_count, corrections);
}

// ---- Identity -------------------------------------------------------------------------------------------------------

const struct vw_box *vw_trainer_effect_box(const struct vw_trainer *trainer) {
    return trainer->model.box_of_effect ? &trainer->model.box : NULL;
}

enum vw_status vw_trainer_list_exposures(const struct vw_trainer *trainer, struct vw_run_exposure **exposures,
                                         uint32_t *count) {
    const struct vw_scene *scene = trainer->scene;
    const struct vw_exposure *estimated = NULL;
    *exposures = NULL;
    *count = 0;
    if (trainer->model.specialization.effect_appearance != APPEARANCE_GIVEN) return VW_OK;
    enum vw_status status = vw_scene_estimate_exposures(scene, &estimated);
    if (!status) *exposures = vw_allocate(scene->view_count, sizeof **exposures);
    if (!status && !*exposures) status = VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count && !status; v++) {
        struct vw_run_exposure *exposure = &(*exposures)[*count];
        if (scene->views[v].split != VW_SPLIT_TRAIN) continue;
        exposure->photo = scene->views[v].name;
        memcpy(exposure->numbers, estimated[v].gain, sizeof estimated[v].gain);
        memcpy(exposure->numbers + 3, estimated[v].bias, sizeof estimated[v].bias);
        ++*count;
    }
    return status;
}

enum vw_status vw_trainer_run_id(const struct vw_trainer *trainer, uint8_t run_id[VW_HASH_BYTES]) {
    const struct vw_gpu_info *device = vw_gpu_get_info(trainer->gpu);
    struct vw_run_identity identity = {.version = vw_version(),
                                       .device = device->name,
                                       .driver = device->driver,
                                       .config = &trainer->config,
                                       .effects = trainer->effects,
                                       .effect_count = trainer->effect_count,
                                       .effect_box = vw_trainer_effect_box(trainer),
                                       .validates = trainer->validate};
    memcpy(identity.scene_hash, trainer->scene->hash, sizeof identity.scene_hash);
    vw_trainer_subset_hash(trainer, identity.subset_hash);
    vw_shader_hash(identity.shader_hash);
    struct vw_run_exposure *exposures = NULL;
    enum vw_status status = vw_trainer_list_exposures(trainer, &exposures, &identity.exposure_count);
    identity.exposures = exposures;
    if (!status) status = vw_identity_run_id(&identity, run_id);
    free(exposures);
    return status;
}

void vw_trainer_subset_hash(const struct vw_trainer *trainer, uint8_t hash[VW_HASH_BYTES]) {
    vw_identity_subset_hash(trainer->scene, &trainer->photo_order, hash);
}

// ---- Files ----------------------------------------------------------------------------------------------------------

enum vw_status vw_trainer_save_checkpoint(struct vw_trainer *trainer, const char *path) {
    uint8_t run_id[VW_HASH_BYTES];
    if (vw_trainer_in_flight(trainer))
        return vw_fail(VW_ERROR_USAGE, "%s: steps are in flight; collect them first", path);
    if (trainer->next_step == 0) return vw_fail(VW_ERROR_USAGE, "%s: nothing to keep before the first step", path);
    enum vw_status status = vw_trainer_run_id(trainer, run_id);
    return !status ? vw_checkpoint_save(path, run_id, trainer->next_step - 1, &trainer->step) : status;
}

enum vw_status vw_trainer_load_checkpoint(struct vw_trainer *trainer, const char *path, uint64_t last_step,
                                          uint64_t *step) {
    uint8_t run_id[VW_HASH_BYTES];
    if (vw_trainer_in_flight(trainer))
        return vw_fail(VW_ERROR_USAGE, "%s: steps are in flight; load before the first advance", path);
    enum vw_status status = vw_trainer_run_id(trainer, run_id);
    if (!status) status = vw_checkpoint_load(path, run_id, last_step, &trainer->step, step);
    if (!status) trainer->next_step = *step + 1;
    return status;
}

enum vw_status vw_trainer_save_field(struct vw_trainer *trainer, const char *path) {
    return vw_field_file_save(path, &trainer->parts);
}

enum vw_status vw_trainer_load_field(struct vw_trainer *trainer, const char *path) {
    return vw_field_file_load(path, &trainer->parts);
}

static enum vw_status add_sky(struct vw_trainer *trainer, float **params, uint32_t *count) {
    const struct vw_param_range *range = &trainer->model.ranges[VW_SLOT_SKY];
    vw_float4 sky[VW_SKY_COLUMNS];
    if (!range->size_bytes) return VW_OK;
    enum vw_status status = vw_buffer_read(trainer->field.params, range->offset_bytes, sky, sizeof sky);
    uint32_t columns = VW_SPLAT_COLUMNS(vw_splat_model_of(&trainer->model)->degree);
    return status ? status : vw_splats_add_sky(sky, columns, params, count);
}

enum vw_status vw_trainer_make_splats(struct vw_trainer *trainer, uint32_t degree, void **data, size_t *size_bytes) {
    const struct vw_splat_model *splats = vw_splat_model_of(&trainer->model);
    *data = NULL;
    *size_bytes = 0;
    if (trainer->config.field != VW_FIELD_SPLATS) return VW_OK;
    uint32_t count = splats->count;
    uint64_t bytes = sizeof(vw_float4) * VW_SPLAT_COLUMNS(splats->degree) * (uint64_t)count;
    float *params = vw_allocate(bytes, 1);
    enum vw_status status = params ? vw_buffer_read(trainer->field.params, 0, params, bytes) : VW_ERROR_MEMORY;
    if (!status) status = add_sky(trainer, &params, &count);
    if (!status)
        status = vw_splat_file_make(params, count, splats->degree, degree, &trainer->model.box, data, size_bytes);
    free(params);
    return status;
}

// ---- Views ----------------------------------------------------------------------------------------------------------

static const double DEPTH_SHARE = 0.01; // the least part of a ray's light that tells a depth

enum vw_status vw_trainer_render(struct vw_trainer *trainer, uint32_t view, float **rgb) {
    const struct vw_camera *camera = &trainer->scene->views[view].camera;
    return vw_trainer_render_small(trainer, view, (uint32_t[]){camera->width_px, camera->height_px}, rgb);
}

enum vw_status vw_trainer_render_small(struct vw_trainer *trainer, uint32_t view, const uint32_t size_px[2],
                                       float **rgb) {
    const struct vw_picture picture = {.view = view, .size_px = {size_px[0], size_px[1]}};
    enum vw_status status = vw_scene_decode(trainer->scene, &view, 1);
    return status ? status : vw_field_render(&trainer->field, &picture, 1, rgb);
}

enum vw_status vw_trainer_render_posed(struct vw_trainer *trainer, uint32_t view, const struct vw_view *posed,
                                       bool depth, float **values) {
    return vw_trainer_render_poses(trainer, &view, posed, 1, depth ? DEPTH_SHARE : 0, values);
}

enum vw_status vw_trainer_render_poses(struct vw_trainer *trainer, const uint32_t *views, const struct vw_view *posed,
                                       uint32_t count, double depth_share, float **values) {
    struct vw_picture *pictures = vw_allocate(count, sizeof *pictures);
    if (!pictures) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++)
        pictures[i] = (struct vw_picture){.view = views[i],
                                          .size_px = {posed->camera.width_px, posed->camera.height_px},
                                          .depth_share = depth_share,
                                          .posed = &posed[i]};
    enum vw_status status = vw_field_render(&trainer->field, pictures, count, values);
    free(pictures);
    return status;
}

static struct vw_measured_field measured_field_of(struct vw_trainer *trainer) {
    return (struct vw_measured_field){.field = &trainer->field,
                                      .scene = trainer->scene,
                                      .masks = trainer->masks,
                                      .fits = vw_effects_fit(&trainer->model)};
}

enum vw_status vw_trainer_measure_views(struct vw_trainer *trainer, const uint32_t *views, uint32_t view_count,
                                        uint32_t pixels_max, struct vw_view_error *errors) {
    const struct vw_measured_field measured = measured_field_of(trainer);
    return vw_measure_views(&measured, views, view_count, pixels_max, errors);
}

enum vw_status vw_trainer_measure_whole(struct vw_trainer *trainer, const struct vw_scene *sized, uint32_t view,
                                        struct vw_whole_view *whole) {
    struct vw_measured_field measured = measured_field_of(trainer);
    if (sized) measured.scene = sized;
    measured.allows_blank = sized != NULL;
    return vw_measure_whole_view(&measured, view, whole);
}
