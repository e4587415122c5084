#include "run/next/next.h"

#include <stdlib.h>

#include "base/memory.h"
#include "run/next/candidate_scores.h"
#include "run/recorded/recorded_run.h"
#include "train/trainer.h"

enum { VAL_PIXELS_MAX = 4096 }; // pixels that the error of a validation photo is measured on

struct known {
    struct vw_known_views views;
    uint32_t *train, *val; // owned, as all below
    double *mse;
    struct vw_view_error *errors;
};

static enum vw_status measure(struct vw_trainer *trainer, struct known *known) {
    uint32_t count = known->views.val_count;
    known->errors = vw_allocate(count, sizeof *known->errors);
    known->mse = vw_allocate(count, sizeof *known->mse);
    if (!known->errors || !known->mse) return VW_ERROR_MEMORY;
    enum vw_status status =
        count ? vw_trainer_measure_views(trainer, known->val, count, VAL_PIXELS_MAX, known->errors) : VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) known->mse[i] = known->errors[i].mse;
    return status;
}

static enum vw_status know(const struct vw_scene *scene, struct vw_trainer *trainer, struct known *known) {
    uint32_t train_count = 0, val_count = 0;
    enum vw_status status = vw_scene_list_views(scene, VW_SPLIT_TRAIN, &known->train, &train_count);
    if (!status) status = vw_scene_list_views(scene, VW_SPLIT_VAL, &known->val, &val_count);
    known->views = (struct vw_known_views){.scene = scene,
                                           .trainer = trainer,
                                           .views = known->train,
                                           .count = train_count,
                                           .val_views = known->val,
                                           .val_count = val_count};
    if (!status) status = measure(trainer, known);
    known->views.val_mse = known->mse;
    return status;
}

static enum vw_status pick(const struct vw_next_params *params, const struct vw_candidate_score *score,
                           const struct vw_known_views *known, struct vw_next *next) {
    uint32_t count = next->candidate_count, wanted = params->count < count ? params->count : count;
    uint32_t *picks = vw_allocate(wanted, sizeof *picks);
    double *gains = vw_allocate(wanted, sizeof *gains);
    next->first_gains = vw_allocate(count, sizeof *next->first_gains);
    next->proposals = vw_allocate(wanted, sizeof *next->proposals);
    enum vw_status status =
        picks && gains && next->first_gains && next->proposals
            ? vw_next_candidates_pick(score, known, next->candidates, count, wanted, picks, gains, next->first_gains)
            : VW_ERROR_MEMORY;
    for (uint32_t k = 0; k < wanted && !status; k++) next->proposals[k] = (struct vw_proposal){picks[k], gains[k]};
    next->proposal_count = status ? 0 : wanted;
    free(picks);
    free(gains);
    return status;
}

enum vw_status vw_next_make(const struct vw_next_params *params, struct vw_next *next) {
    struct vw_recorded_run run = {0};
    struct vw_trainer *trainer = NULL;
    struct known known = {0};
    const struct vw_candidate_score *score = NULL;
    *next = (struct vw_next){0};
    enum vw_status status = vw_candidate_score_find(params->method, &score);
    if (!status) status = vw_recorded_open(params->out, &run);
    if (!status) status = vw_recorded_open_scene(&run, params->device);
    if (!status) status = vw_next_candidates_read(run.scene, params->among, &next->candidates, &next->candidate_count);
    if (!status) status = vw_recorded_load_field(&run, true, &trainer);
    if (!status) status = know(run.scene, trainer, &known);
    if (!status) status = pick(params, score, &known.views, next);
    if (!status) next->method = score->name;
    free(known.train);
    free(known.val);
    free(known.mse);
    free(known.errors);
    vw_trainer_destroy(&trainer);
    vw_recorded_close(&run);
    return status;
}

void vw_next_free(struct vw_next *next) {
    vw_next_candidates_free(&next->candidates, next->candidate_count);
    free(next->first_gains);
    free(next->proposals);
    *next = (struct vw_next){0};
}
