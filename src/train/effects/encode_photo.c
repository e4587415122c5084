#include "train/effects/encode_photo.h"

#include <math.h>

#include "gpu/shaders.h"
#include "image/image.h"
#include "train/field.h"
#include "train/passes.h"

struct vw_param_range vw_encoder_network(const struct vw_model *model) {
    const struct vw_specialization *s = &model->specialization;
    if (!s->effect_appearance_encoder) return (struct vw_param_range){0};
    return vw_model_columns(model, s->encoder_column, VW_ENCODER_COLUMNS(s->width4));
}

enum vw_status vw_encoder_set_thumbnail(const struct vw_radiance_field *field, const struct vw_scene *scene,
                                        uint32_t view, const struct vw_thumbnail_choice *choice) {
    vw_float4 thumbnail[THUMBNAIL_PIXELS];
    if (!field->model->specialization.effect_appearance_encoder) return VW_OK;
    vw_thumbnail_make(&scene->views[view], choice, thumbnail);
    return vw_buffer_write(field->effect_buffers[VW_SLOT_THUMBNAILS], (uint64_t)view * sizeof thumbnail, thumbnail,
                           sizeof thumbnail);
}

enum vw_status vw_encoder_create_passes(struct vw_gpu_objects *objects, const struct vw_pass_params *common, bool back,
                                        struct vw_effect_passes *set) {
    const struct vw_pass_row rows[ENCODER_PASSES] = {
        {&vw_shader_convolve_photo, &set->passes[ENCODER_CONVOLVE]},
        {&vw_shader_pool_photo, &set->passes[ENCODER_POOL]},
        {&vw_shader_spread_photo_codes, &set->passes[ENCODER_SPREAD]},
        {&vw_shader_convolve_photo_back, &set->passes[ENCODER_CONVOLVE_BACK]},
        {&vw_shader_gradient_photo, &set->passes[ENCODER_GRADIENT]},
    };
    return vw_passes_create(objects, common, rows, back ? ENCODER_PASSES : ENCODER_SPREAD);
}

void vw_encoder_record_forward(struct vw_pass *const *passes, struct vw_submission *submission, uint32_t view) {
    struct vw_push_photo push = {.view = view};
    for (; push.layer < ENCODER_LAYERS; push.layer++)
        vw_submission_dispatch(submission, passes[ENCODER_CONVOLVE], &push, sizeof push,
                               (uint64_t)ENCODER4 * THUMBNAIL_PIXELS >> 2 * (push.layer + 1));
    vw_submission_dispatch(submission, passes[ENCODER_POOL], NULL, 0, 1);
}

void vw_encoder_record_back(struct vw_pass *const *passes, const struct vw_push_codes *codes,
                            struct vw_submission *submission) {
    struct vw_push_photo push = {.layer = ENCODER_LAYERS - 1};
    vw_submission_dispatch(submission, passes[ENCODER_SPREAD], codes, codes ? sizeof *codes : 0, 1);
    for (; push.layer > 0; push.layer--)
        vw_submission_dispatch(submission, passes[ENCODER_CONVOLVE_BACK], &push, sizeof push,
                               (uint64_t)ENCODER4 * THUMBNAIL_PIXELS >> 2 * push.layer);
    vw_submission_dispatch(submission, passes[ENCODER_GRADIENT], NULL, 0, ENCODER_CODE);
}

// ---- Thumbnails -----------------------------------------------------------------------------------------------------

struct part { // a part of a side, in pixels
    double begin, end;
};

static struct part part_of(uint32_t index, double side_px) {
    return (struct part){index * side_px / THUMBNAIL_SIDE, (index + 1) * side_px / THUMBNAIL_SIDE};
}

// Returns how much of a pixel lies in a part.
static double overlap(const struct part *part, uint32_t at_px) {
    return fmin(part->end, at_px + 1.0) - fmax(part->begin, at_px);
}

// Adds one pixel times its area to the sum, where the pixel counts.
static void add_pixel(const struct vw_view *view, bool masks, uint32_t x_px, uint32_t y_px, double area,
                      double sum[4]) {
    float rgba[4];
    if (!(masks ? vw_view_keeps(view, x_px, y_px) : vw_view_can_use(view, x_px, y_px))) return;
    vw_image_pixel(&view->image, x_px, y_px, rgba);
    for (int c = 0; c < 3; c++) sum[c] += area * rgba[3] * (2.0 * rgba[c] - 1.0);
    sum[3] += area * rgba[3];
}

static vw_float4 mean_of(const struct vw_view *view, const struct vw_thumbnail_choice *choice,
                         const struct part *columns, const struct part *rows) {
    double sum[4] = {0}, area = (columns->end - columns->begin) * (rows->end - rows->begin);
    for (uint32_t y = (uint32_t)rows->begin; y < rows->end && y < view->image.height_px; y++)
        for (uint32_t x = (uint32_t)columns->begin; x < columns->end && x < choice->columns.end; x++)
            add_pixel(view, choice->masks, x, y, overlap(columns, x) * overlap(rows, y), sum);
    return (vw_float4){(float)(sum[0] / area), (float)(sum[1] / area), (float)(sum[2] / area), (float)(sum[3] / area)};
}

void vw_thumbnail_make(const struct vw_view *view, const struct vw_thumbnail_choice *choice, vw_float4 *thumbnail) {
    uint32_t first = choice->columns.begin;
    for (uint32_t i = 0; i < THUMBNAIL_PIXELS; i++) {
        struct part columns = part_of(i % THUMBNAIL_SIDE, choice->columns.end - first),
                    rows = part_of(i / THUMBNAIL_SIDE, view->image.height_px);
        columns.begin += first;
        columns.end += first;
        thumbnail[i] = mean_of(view, choice, &columns, &rows);
    }
}
