#include <stdlib.h>

#include "base/memory.h"
#include "lab/gradients/gradient_replay.h"

static enum vw_status find_gradient(const struct vw_gradient_replay *gradient_replay) {
    vw_submission_begin(gradient_replay->replay.submission);
    vw_gradient_replay_record_validation(gradient_replay, 0);
    return vw_step_replay_run(&gradient_replay->replay);
}

static enum vw_status add_checkpoint(struct vw_gradient_replay *gradient_replay, uint64_t step,
                                     struct vw_photo_products *products, struct vw_tracin_score *scores) {
    const struct vw_trainer_parts *context = gradient_replay->replay.context;
    double rate = context->config->learning_rate * vw_model_rate_factor_of_step(context->field->model, step + 1);
    enum vw_status status = vw_gradient_replay_go_to(gradient_replay, step);
    if (!status) status = find_gradient(gradient_replay);
    if (!status) status = vw_gradient_replay_try_photos(gradient_replay, step + 1, products);
    for (uint32_t i = 0; i < context->photo_order->train_count && !status; i++) {
        scores[i].plain -= rate * products[i].by_gradient;
        scores[i].preconditioned += products[i].by_step;
    }
    return status;
}

// Adds up all checkpoints. Checkpoint i of C is the end of the epoch at (i + 1) / C of those after burn-in.
static enum vw_status add_checkpoints(struct vw_gradient_replay *gradient_replay, uint32_t checkpoints,
                                      struct vw_tracin_score *scores) {
    const struct vw_photo_order *photo_order = gradient_replay->replay.context->photo_order;
    const struct vw_config *config = gradient_replay->replay.context->config;
    uint64_t burn_in = config->burn_in_epochs < config->epochs ? config->burn_in_epochs : 0,
             counted = config->epochs - burn_in;
    if (checkpoints > counted) checkpoints = (uint32_t)counted;
    struct vw_photo_products *products = vw_allocate(photo_order->train_count, sizeof *products);
    enum vw_status status = products ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < photo_order->train_count && !status; i++) scores[i] = (struct vw_tracin_score){0};
    for (uint32_t i = 1; i <= checkpoints && !status; i++)
        status = add_checkpoint(gradient_replay, photo_order->train_count * (burn_in + counted * i / checkpoints),
                                products, scores);
    free(products);
    return status;
}

enum vw_status vw_tracin_scores(const struct vw_gradient_params *params, uint32_t checkpoints,
                                struct vw_tracin_score *scores) {
    struct vw_gradient_replay gradient_replay = {0};
    enum vw_status status = vw_gradient_replay_create(params, &gradient_replay);
    if (!status) status = add_checkpoints(&gradient_replay, checkpoints, scores);
    vw_gradient_replay_destroy(&gradient_replay);
    return status;
}
