// Influence functions by LiSSA. The vectors are on the host, in double: an iteration costs one product on the device.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "lab/gradients/influence_private.h"
#include "viewworth/log.h"

// ---- Adam's rates ---------------------------------------------------------------------------------------------------

static double bias_correction(double beta, double visits) { return 1.0 - pow(beta, visits); }

// Returns Adam's step per gradient for a param with this second moment: the learning rate over Adam's divisor.
static double rate_of(const struct vw_influence *influence, double moment2, double visits) {
    const struct vw_trainer_parts *context = influence->gradient_replay.replay.context;
    const struct vw_specialization *s = &context->field->model->specialization;
    double rate = context->config->learning_rate *
                  vw_model_rate_factor_of_step(context->field->model, influence->gradient_replay.step);
    if (context->config->optimizer == VW_OPTIMIZER_SGD) return rate;
    if (visits == 0.0) return 0.0; // nothing is known of it, and training has never moved it
    return rate / (sqrt(moment2 / bias_correction(s->beta2, visits)) + (double)s->gradient_quantum * s->inverse_rays);
}

static enum vw_status read_grid_rates(struct vw_influence *influence) {
    const struct vw_trainer_parts *context = influence->gradient_replay.replay.context;
    const struct vw_volume_model *volume = vw_volume_of(context->field->model);
    bool lazy = context->config->optimizer == VW_OPTIMIZER_LAZY_ADAM;
    double *rates = influence->rates + volume->grid.offset_bytes / sizeof(float);
    uint32_t *visits = vw_allocate(volume->pair_count, sizeof *visits);
    enum vw_status status = visits ? VW_OK : VW_ERROR_MEMORY;
    if (!status)
        status = vw_buffer_read(vw_volume_step_of(context->step)->grid_moment2, 0, influence->block,
                                8ull * volume->pair_count);
    if (!status)
        status = vw_buffer_read(vw_volume_step_of(context->step)->grid_visits, 0, visits,
                                sizeof *visits * (uint64_t)volume->pair_count);
    for (uint64_t i = 0; i < 2ull * volume->pair_count && !status; i++)
        rates[i] =
            rate_of(influence, influence->block[i], lazy ? visits[i / 2] : (double)influence->gradient_replay.step);
    free(visits);
    return status;
}

// Reads the rates of the weights and the sky.
static enum vw_status read_weight_rates(struct vw_influence *influence) {
    const struct vw_step_passes *step = influence->gradient_replay.replay.context->step;
    const struct vw_model *model = step->field->model;
    uint64_t moved_bytes = 16ull * model->moved_columns, moved = 4ull * model->followed_columns;
    double *rates = influence->rates + model->weights.offset_bytes / sizeof(float);
    enum vw_status status = vw_buffer_read(step->weight_moments, moved_bytes, influence->block, moved_bytes);
    for (uint64_t i = 0; i < moved && !status; i++)
        rates[i] = rate_of(influence, influence->block[i], (double)influence->gradient_replay.step);
    return status;
}

static enum vw_status read_rates(struct vw_influence *influence) {
    const struct vw_model *model = influence->gradient_replay.replay.context->field->model;
    enum vw_status status = vw_volume_of(model)->grid.size_bytes ? read_grid_rates(influence) : VW_OK;
    return !status ? read_weight_rates(influence) : status;
}

// ---- LiSSA ----------------------------------------------------------------------------------------------------------

// Returns the length of x in the metric of P, in which P H is symmetric.
static double size_of(const struct vw_influence *influence, const double *values) {
    double sum = 0.0;
    for (uint64_t i = 0; i < influence->count; i++)
        if (influence->rates[i] > 0.0) sum += values[i] * values[i] / influence->rates[i];
    return sqrt(sum);
}

static enum vw_status read_adjoint(const struct vw_influence *influence) {
    return vw_buffer_read(influence->gradient_replay.passes.adjoint.blocks.lambda, 0, influence->block,
                          influence->count * sizeof *influence->block);
}

static enum vw_status find_pull(struct vw_influence *influence) {
    struct vw_gradient_replay *gradient_replay = &influence->gradient_replay;
    vw_submission_begin(gradient_replay->replay.submission);
    vw_gradient_replay_record_validation(gradient_replay, 0);
    vw_submission_copy(gradient_replay->replay.submission, gradient_replay->replay.context->field->params, 0,
                       gradient_replay->passes.blocks.before, 0, influence->count * sizeof(float));
    enum vw_status status = vw_step_replay_run(&gradient_replay->replay);
    if (!status) status = read_adjoint(influence);
    for (uint64_t i = 0; i < influence->count && !status; i++)
        influence->pull[i] = influence->rates[i] * influence->block[i];
    return status;
}

// Sets the direction. Colours are taken as far forward and backward along it as reduce_adjoint says for directions of
// its own.
static enum vw_status set_direction(const struct vw_adjoint_passes *passes, const float *direction) {
    uint64_t bytes = passes->context->field->model->param_bytes;
    float *before = vw_allocate(bytes, 1);
    if (!before) return VW_ERROR_MEMORY;
    double size = 0.0, along = 0.0;
    enum vw_status status = vw_buffer_read(passes->blocks.before, 0, before, bytes);
    for (uint64_t i = 0; i < bytes / sizeof *before; i++) {
        size += (double)before[i] * before[i];
        along += (double)direction[i] * direction[i];
    }
    free(before);
    const struct vw_adjoint_state state = {.epsilon = along > 0.0 ? (float)(1e-3 * sqrt(size / along)) : 0.0f};
    if (!status) status = vw_buffer_write(passes->state, 0, &state, sizeof state);
    return !status ? vw_buffer_write(passes->direction, 0, direction, bytes) : status;
}

// Adds to the adjoint the curvature of the mean loss of those pixels times the direction. The random numbers are those
// of step `number`.
static void record_curvature(const struct vw_gradient_replay *gradient_replay, uint64_t number, uint32_t first_pixel) {
    const struct vw_step_passes *step = gradient_replay->replay.context->step;
    struct vw_submission *submission = gradient_replay->replay.submission;
    const struct vw_push_rays rays = {.first_pixel = first_pixel,
                                      .ray_count = vw_step_counted_rays(step, first_pixel),
                                      .key = vw_model_key_of_step(step->field->model, number)};
    vw_submission_dispatch(submission, vw_volume_step_of(step)->gradient.of_rays.generate, &rays, sizeof rays,
                           step->padded_rays);
    vw_adjoint_record_product(&gradient_replay->passes, submission, &rays);
}

enum vw_status vw_influence_multiply(struct vw_influence *influence, uint32_t index) {
    struct vw_gradient_replay *gradient_replay = &influence->gradient_replay;
    const struct vw_step_replay *replay = &gradient_replay->replay;
    const struct vw_photo_order *photo_order = replay->context->photo_order;
    uint64_t number = gradient_replay->step + 1 + index; // no step of the training has its draws
    for (uint64_t i = 0; i < influence->count; i++) influence->block[i] = (float)influence->x[i];
    enum vw_status status = set_direction(&gradient_replay->passes, influence->block);
    if (status) return status;
    vw_submission_begin(replay->submission);
    uint32_t pixel =
        vw_step_replay_draw_photo(replay, photo_order->train_views[index % photo_order->train_count], number, 0, 0);
    vw_gradient_replay_record_zero(gradient_replay);
    record_curvature(gradient_replay, number, pixel);
    status = vw_step_replay_run(replay);
    return !status ? read_adjoint(influence) : status;
}

// Makes one iteration. `holds`: it has not lengthened x.
static enum vw_status iterate(struct vw_influence *influence, uint32_t index, bool *holds) {
    double damping = influence->settings.damping;
    enum vw_status status = vw_influence_multiply(influence, index);
    if (status) return status;
    for (uint64_t i = 0; i < influence->count; i++)
        influence->carried[i] =
            (1.0 - damping) * influence->x[i] - influence->rates[i] * influence->block[i] / influence->scale;
    *holds = size_of(influence, influence->carried) <= influence->size; // also not when it is not finite
    for (uint64_t i = 0; i < influence->count; i++) influence->x[i] = influence->pull[i] + influence->carried[i];
    influence->size = size_of(influence, influence->x);
    return VW_OK;
}

static enum vw_status try_scale(struct vw_influence *influence, struct vw_influence_result *result) {
    uint32_t counted = influence->settings.iterations - influence->first_counted;
    enum vw_status status = VW_OK;
    bool holds = true;
    for (uint64_t i = 0; i < influence->count; i++) influence->x[i] = influence->pull[i], influence->mean[i] = 0.0;
    influence->size = size_of(influence, influence->x);
    for (uint32_t k = 0; k < influence->settings.iterations && holds && !status; k++) {
        status = vw_gradient_replay_check_interrupt(&influence->gradient_replay);
        if (!status) status = iterate(influence, k, &holds);
        for (uint64_t i = 0; i < influence->count && k >= influence->first_counted; i++)
            influence->mean[i] += influence->x[i] / (counted * influence->scale);
        result->iterations++;
    }
    result->found = holds;
    return status;
}

enum vw_status vw_influence_solve(struct vw_influence *influence, struct vw_influence_result *result) {
    enum vw_status status = VW_OK;
    for (influence->scale = influence->settings.scale; influence->scale <= influence->settings.scale_max && !status;
         influence->scale *= 2) {
        status = try_scale(influence, result);
        if (!status && result->found) break;
    }
    if (status) return status;
    if (!result->found) {
        vw_log_warning("influence: its iterations diverge up to a scale of %g, so there is no score",
                       influence->settings.scale_max);
        return VW_OK;
    }
    double pull = size_of(influence, influence->pull);
    result->scale = influence->scale;
    result->size = influence->size;
    result->growth = pull > 0.0 ? influence->size / pull : 0.0;
    vw_log_info("influence  %u products, scale %g, damping %g; growth %.3g of at most %.3g", result->iterations,
                result->scale, influence->settings.damping, result->growth, 1.0 / influence->settings.damping);
    return VW_OK;
}

// ---- Scores ---------------------------------------------------------------------------------------------------------

// Restores the params, which the products have overwritten.
static enum vw_status restore_params(const struct vw_gradient_replay *gradient_replay) {
    vw_submission_begin(gradient_replay->replay.submission);
    vw_submission_copy(gradient_replay->replay.submission, gradient_replay->passes.blocks.before, 0,
                       gradient_replay->replay.context->field->params, 0, vw_buffer_size_bytes(gradient_replay->zeros));
    return vw_step_replay_run(&gradient_replay->replay);
}

enum vw_status vw_influence_score(struct vw_influence *influence, double *scores) {
    struct vw_gradient_replay *gradient_replay = &influence->gradient_replay;
    uint32_t photos = gradient_replay->replay.context->photo_order->train_count, draws = influence->settings.draws;
    struct vw_photo_products *products = vw_allocate(photos, sizeof *products);
    if (!products) return VW_ERROR_MEMORY;
    for (uint64_t i = 0; i < influence->count; i++) influence->block[i] = (float)influence->mean[i];
    enum vw_status status = restore_params(gradient_replay);
    if (!status)
        status = vw_buffer_write(gradient_replay->passes.adjoint.blocks.lambda, 0, influence->block,
                                 influence->count * sizeof *influence->block);
    for (uint32_t i = 0; i < photos; i++) scores[i] = 0.0;
    for (uint32_t draw = 0; draw < draws && !status; draw++) {
        status = vw_gradient_replay_try_photos(gradient_replay, gradient_replay->step + 1 + draw, products);
        for (uint32_t i = 0; i < photos && !status; i++)
            scores[i] -= products[i].by_gradient / ((double)draws * photos);
    }
    free(products);
    return status;
}

static void set_defaults(struct vw_influence *influence) {
    struct vw_influence_settings *settings = &influence->settings;
    uint32_t photos = influence->gradient_replay.replay.context->photo_order->train_count;
    if (!settings->damping) settings->damping = VW_INFLUENCE_DAMPING;
    if (!settings->scale) settings->scale = 1;
    if (!settings->scale_max) settings->scale_max = VW_INFLUENCE_SCALE_MAX;
    if (!settings->draws) settings->draws = VW_INFLUENCE_DRAWS;
    uint32_t passes = VW_INFLUENCE_PASSES * photos;
    if (!settings->iterations)
        settings->iterations = passes > VW_INFLUENCE_ITERATIONS ? passes : VW_INFLUENCE_ITERATIONS;
    uint32_t half = (settings->iterations + 1) / 2;
    influence->first_counted = settings->iterations - (half < photos ? half : half / photos * photos);
}

static enum vw_status allocate(struct vw_influence *influence) {
    double **vectors[] = {&influence->rates, &influence->pull, &influence->x, &influence->carried, &influence->mean};
    influence->count = influence->gradient_replay.replay.context->field->model->param_bytes / sizeof(float);
    influence->block = vw_allocate(influence->count, sizeof *influence->block);
    bool all = influence->block != NULL;
    for (size_t i = 0; i < VW_ARRAY_COUNT(vectors); i++) {
        *vectors[i] = vw_allocate(influence->count, sizeof **vectors[i]);
        all = all && *vectors[i];
    }
    return all ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_influence_create(const struct vw_gradient_params *params,
                                   const struct vw_influence_settings *settings, struct vw_influence *influence) {
    *influence = (struct vw_influence){.settings = *settings};
    enum vw_status status = vw_gradient_replay_create(params, &influence->gradient_replay);
    if (!status) status = allocate(influence);
    if (!status)
        status = vw_gradient_replay_go_to(&influence->gradient_replay, influence->gradient_replay.replay.total_steps);
    if (status) return status;
    set_defaults(influence);
    status = read_rates(influence);
    return !status ? find_pull(influence) : status;
}

void vw_influence_destroy(struct vw_influence *influence) {
    double *vectors[] = {influence->rates, influence->pull, influence->x, influence->carried, influence->mean};
    for (size_t i = 0; i < VW_ARRAY_COUNT(vectors); i++) free(vectors[i]);
    free(influence->block);
    vw_gradient_replay_destroy(&influence->gradient_replay);
}

enum vw_status vw_influence_scores(const struct vw_gradient_params *params,
                                   const struct vw_influence_settings *settings, double *scores,
                                   struct vw_influence_result *result) {
    struct vw_influence influence;
    *result = (struct vw_influence_result){0};
    enum vw_status status = vw_influence_create(params, settings, &influence);
    if (!status) status = vw_influence_solve(&influence, result);
    if (!status && result->found) status = vw_influence_score(&influence, scores);
    for (uint32_t i = 0;
         !status && !result->found && i < influence.gradient_replay.replay.context->photo_order->train_count; i++)
        scores[i] = NAN;
    vw_influence_destroy(&influence);
    return status;
}
